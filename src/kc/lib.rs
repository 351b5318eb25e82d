//! Kinematics and compliance (K&C) of an axle, as suspension engineers measure them.
//!
//! [`run`](fn@run) runs the standard tests of a [`Config`] on a [`Bench`]. [`ride`], [`roll`], [`wheel`], [`anti`] and [`swing_arm`]
//! contain the characteristics, one function for each definition. They are computed from the wheel positions and from the compliance matrix
//! of the wheel centres, which follows exactly from the tangent stiffness at equilibrium. The guide page `kc` lists definitions, signs and
//! their sources.
//!
//! Vectors are in the axes of Adams/Car: X rearward, Y to the right, Z up; [`Frame`] converts from the axes of a deck. Lengths and forces
//! are in the units of the deck, angles in radians. This crate does not read measurements.
#![warn(unreachable_pub)]
// The documentation of private modules links to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

pub mod anti;
mod axle;
mod bench;
mod bench_error;
mod compiled;
mod compliance;
mod config;
pub mod contact;
mod deck_change;
mod deck_files;
mod derivatives;
pub(crate) mod force_compliance;
mod frame;
#[cfg(test)]
mod golden;
mod gradient;
mod inputs;
pub mod output;
mod plausibility;
mod reading;
mod replay;
pub mod ride;
mod rig;
pub mod roll;
mod sample;
mod shown;
mod side;
mod steer_axis;
mod steering;
mod sweep;
pub mod swing_arm;
mod test_kind;
mod test_settings;
mod tyre;
pub mod wheel;
mod wheel_rate;

pub(crate) use anti::{Anti, AxlePlace, Vehicle};
pub use axle::{AxleState, Given};
pub use bench::{Bench, Observation, Probed, WheelChanges};
pub use bench_error::BenchError;

pub use compliance::Compliance;
pub(crate) use compliance::Mat12;
pub use config::Config;
pub use deck_change::DeckChange;
pub use deck_files::deck_files;
pub(crate) use force_compliance::Pairing;
pub(crate) use frame::Direction;
pub use frame::{Convention, Frame, Sense};
pub use gradient::Gradient;
pub use gradient::fitted_slope;
pub use gradient::has_reading_change;
pub use gradient::loop_half_width;
pub use gradient::reading_change;
pub use inputs::{Drive, Inputs};
pub use reading::{Reading, Unit};
pub use replay::BodyPoint;
pub use replay::ReplayError;
pub use replay::{Replay, ReplayOptions, Road};
pub use rig::Variant;

pub use sample::{Branch, Sample};
pub use shown::driven_unit;
pub use shown::shown;
pub use shown::slope;
pub use shown::unit_in_deck;
pub use side::Side;
pub use steer_axis::SteerAxis;
pub use steering::Steering;
pub use sweep::TestRun;
pub use sweep::run_watched;
pub use sweep::{KcRun, given, run};
pub use swing_arm::VerticalLoad;
pub(crate) use swing_arm::roll_centre;
pub use test_kind::{Driven, TestKind};
pub use test_settings::Hold;
pub use test_settings::LoadPoint;
pub use tyre::Tyre;
pub use wheel::Wheel;
pub use wheel_rate::WheelRate;
