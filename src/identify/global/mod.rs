//! `method = "gauss-newton"`: one fit of everything that was read.
//!
//! Unknowns are logarithms of stiffnesses, assembly offsets, and what the measurement itself gets wrong; predictions come with
//! sensitivities from the built-in solver, or with differences from any backend.

mod channel;
pub mod confidence;
mod differences;
mod fit;
mod free;
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

pub use fit::{Found, GlobalFit, POOR_NORMAL, StartValues, fit_unknowns, global_problem, identify};
pub(crate) use fit::{UNIDENTIFIABLE, effective_dof};
pub(crate) use free::{STEPS, SeenMark, step};
pub use marginal::Joint;
pub(crate) use marginal::{Marginal, MarginalProblem};
pub(crate) use memory::Carries;
pub use memory::Memory;
pub(crate) use native::NativePredictor;
pub(crate) use observation::{Evaluation, NuisanceLayout};
pub use observation::{FrameMotions, Observations, Row};
pub(crate) use predictor::{
    CaseChange, CaseChanges, CasePrediction, Observed, Prediction, Predictor,
};
pub use prepared::Prepared;
pub(crate) use problem::GlobalProblem;
pub use problem::Watch;
pub use profile::profile_interval;
pub use study::{Options, Start, fit_study};
pub use unknown::{Component, Meaning, Numbers};
pub(crate) use unknown::{Direction, FitUnknown, FitUnknowns};
