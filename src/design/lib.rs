//! Design of experiments: what to measure next.
//!
//! [`plan`](fn@plan) ranks load cases, repeats, marks and channels by what each would add to stiffnesses, to the curves of the wheel, and
//! to the choice between causes. [`propose`] adds to a diagnosis the measurement that tells a finding from its rival. Everything is linear
//! at the fit: nothing is fitted again. From the bottom up: `candidate` <- `forecast` <- `prospect` <- `information` <- `rivals` <-
//! `next_measurement`, `plan`.
#![warn(unreachable_pub)]
// Modules that are private link to what is private with them.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

mod candidate;
mod forecast;
mod information;
mod next_measurement;
mod plan;
mod prospect;
mod rivals;
mod wheel_place;

pub use candidate::Kind;
pub use next_measurement::propose;
pub use plan::{Aim, Combination, Curves, Plan, Ranked, Undecided, WheelSd, plan};
pub use rivals::Separation;
