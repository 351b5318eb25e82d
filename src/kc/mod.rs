//! Kinematics and compliance (K&C) of an axle: what suspension engineers measure.
//!
//! Characteristics come from the places of the wheels, and from the exact compliance matrix of their centres that the tangent at
//! equilibrium gives. One function a definition; definitions, signs and their sources are in the guide, page `kc`. Vectors in this
//! room are in the axes of Adams/Car: X rearward, Y to the right, Z up; [`Frame`] brings those of a deck there. Lengths and forces in
//! the units of the deck, angles in radians. Knows nothing about measurements.

pub mod anti;
mod axle;
mod compliance;
pub mod contact;
pub mod force_compliance;
mod frame;
#[cfg(test)]
mod golden;
mod reading;
mod replay;
pub mod ride;
pub mod roll;
mod side;
mod steer_axis;
mod steering;
pub mod swing_arm;
pub mod wheel;

pub use anti::{Anti, Vehicle};
pub use axle::{AxleState, Given, Tyre, WheelState};
pub use compliance::{Compliance, Mat12};
pub use force_compliance::Pairing;
pub use frame::{Convention, Direction, Frame, Sense};
pub use reading::{Reading, Unit};
pub use replay::{Replay, ReplayError, ReplayOptions, Road};
pub use side::Side;
pub use steer_axis::SteerAxis;
pub use steering::Steering;
pub use swing_arm::{RollCentre, VerticalLoad, roll_centre};
pub use wheel::Wheel;
