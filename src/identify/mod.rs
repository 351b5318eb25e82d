//! From measurements to stiffnesses: the paper's loop, a direct solution, and a fit of everything that was read.
//!
//! Knows no files and prints nothing.

pub mod confidence;
pub mod gauss_newton;
mod native;
mod observation;
mod predictor;
mod problem;
mod stiffness;
mod unknown;

pub use native::{Loads, NativePredictor};
pub use observation::{Evaluation, NuisanceLayout, Observations, Row};
pub use predictor::{CaseChange, CasePrediction, Observed, Prediction, Predictor};
pub use problem::{Problem, Watch};
pub use stiffness::{Identified, bushing_address, identified, initial_value, unknowns};
pub use unknown::{Component, Direction, Meaning, Unknown, Unknowns};
