//! Kinematics and compliance (K&C) of an axle: what suspension engineers measure.
//!
//! Characteristics come from the places of the wheels, and from the exact compliance matrix of their centres that the tangent at
//! equilibrium gives. One function a definition; definitions, signs and their sources are in the guide, page `kc`. Vectors in this
//! room are in the axes of Adams/Car: X rearward, Y to the right, Z up; [`Frame`] brings those of a deck there. Lengths and forces in
//! the units of the deck, angles in radians. Knows nothing about measurements.

pub mod anti;
mod axle;
mod bench;
mod compliance;
mod config;
pub mod contact;
mod deck_files;
mod derivatives;
pub mod force_compliance;
mod frame;
#[cfg(test)]
mod golden;
mod gradient;
mod inputs;
pub mod output;
mod reading;
mod replay;
pub mod ride;
mod rig;
pub mod roll;
mod sample;
mod side;
mod steer_axis;
mod steering;
mod sweep;
pub mod swing_arm;
mod test_kind;
mod test_settings;
pub mod wheel;

pub use anti::{Anti, Vehicle};
pub use axle::{AxleState, Given, Tyre, WheelState};
pub use bench::{Bench, BenchError, Chain, Observation, WheelRate};
pub use compliance::{Compliance, Mat12};
pub use config::{AxisMethod, Config};
pub use deck_files::deck_files;
pub use force_compliance::Pairing;
pub use frame::{Convention, Direction, Frame, Sense};
pub use gradient::{Gradient, fitted_slope, loop_half_width};
pub use inputs::{Drive, Inputs};
pub use reading::{Reading, Unit};
pub use replay::{BodyPoint, Replay, ReplayError, ReplayOptions, Road};
pub use rig::{FoundWheel, Rigged, Variant, WheelIds};
pub use sample::{Branch, Sample};
pub use side::Side;
pub use steer_axis::SteerAxis;
pub use steering::Steering;
pub use sweep::{KcRun, TestRun, given, run, run_watched};
pub use swing_arm::{RollCentre, VerticalLoad, roll_centre};
pub use test_kind::{Driven, TestKind};
pub use test_settings::{Branches, Hold, LoadPoint, TestSettings};
pub use wheel::Wheel;
