//! `method = "gauss-newton"`: one fit of everything that was read.
//!
//! Unknowns are logarithms of stiffnesses, assembly offsets, and what the measurement itself gets wrong; predictions come with
//! sensitivities from the built-in solver, or with differences from any backend.

mod channel;
pub mod confidence;
mod differences;
mod fit;
pub mod gauss_newton;
mod held_curves;
mod marginal;
mod memory;
mod native;
mod observation;
mod predictor;
mod prepared;
mod problem;
mod profile;
mod study;
mod unknown;

pub use differences::DifferencePredictor;
pub use fit::{
    Found, GlobalFit, POOR_NORMAL, StartValues, UNIDENTIFIABLE, effective_dof, fit_unknowns,
    global_problem, identify,
};
pub use marginal::{Joint, Marginal, MarginalProblem};
pub use memory::{Carries, Memory};
pub use native::NativePredictor;
pub use observation::{Evaluation, NuisanceLayout, Observations, Row};
pub use predictor::{CaseChange, CasePrediction, Observed, Prediction, Predictor};
pub use prepared::Prepared;
pub use problem::{GlobalProblem, Watch};
pub use profile::profile_interval;
pub use study::{Options, Start, fit_study};
pub use unknown::{Component, Direction, FitUnknown, FitUnknowns, Meaning, Numbers};
