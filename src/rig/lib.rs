//! A virtual test rig: it simulates measurements on a deck, as a real rig takes them on an axle.
//!
//! [`virtual_rig()`] solves the load cases of a study with a changed deck and returns the readings as a new study folder. [`effect`] contains
//! the effects that can be planted in the deck or in the readings, one file for each. [`Tolerances`] holds the sizes of the small errors of
//! every axle and rig. [`Scatter`] describes the noise of the marks (measured points on parts). The force laws of planted effects are
//! implemented independently of the laws that the diagnosis fits.
#![warn(unreachable_pub)]
// The documentation of private modules links to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

pub mod effect;
mod frame_motion;
mod load_table;
mod readings;
mod rest;
mod rig_options;
mod scatter;
mod spin;
mod study_folder;
mod tolerances;
mod virtual_rig;

pub use load_table::LoadTable;
pub use rig_options::RigOptions;
pub use scatter::Scatter;
pub use tolerances::Tolerances;
pub use virtual_rig::virtual_rig_watched;
pub use virtual_rig::{RigRun, virtual_rig};
