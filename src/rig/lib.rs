//! A virtual test rig that measures a deck as a real rig measures an axle.
//!
//! [`virtual_rig()`] solves the load cases of a study with a changed deck and writes the readings as a new study folder. [`effect`] holds the
//! effects that can be planted in the deck or the readings, one file each. [`Tolerances`] are the small errors of every axle and rig,
//! [`Scatter`] the noise of the marks. The force laws of planted effects are implemented separately from the laws that the diagnosis fits.
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
