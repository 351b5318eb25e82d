//! Design of experiments: the choice of the next measurement.
//!
//! [`plan`](fn@plan) ranks load cases, repetitions, marks (measured points on parts), wheel curves and load cells. The criteria are the
//! information about stiffnesses, about the wheel's curves, and about the choice between causes. [`propose`] adds to a diagnosis the
//! measurement that distinguishes a finding from its rival. All predictions are linearised at the fit; nothing is refitted.
//!
//! Modules import in one direction only. In `a <- b`, module `b` imports module `a`: `load_values` <- `candidate` <- `forecast` <- `prospect` <-
//! `information` <- `rivals` <- `separator` <- `next_measurement`, `plan`.
#![warn(unreachable_pub)]
// The documentation of private modules links to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

mod candidate;
mod forecast;
mod information;
mod load_values;
mod next_measurement;
mod plan;
mod prospect;
mod rivals;
mod separator;
pub mod settings;
mod wheel_place;

pub use candidate::Kind;
pub use next_measurement::propose;
pub use plan::{Aim, Combination, Curves, Plan, Ranked, Undecided, WheelSd, plan};
pub use rivals::Separation;
pub use separator::Separator;
