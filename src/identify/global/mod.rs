//! `method = "gauss-newton"`: one least-squares fit of all readings.
//!
//! The unknowns are logarithms of stiffnesses, assembly offsets, and errors of the measurement itself. The built-in solver gives predictions
//! with exact sensitivities. For any other backend, the sensitivities are finite differences.

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
mod start_values;
mod study;
mod unknown;

pub use channel::{StateSensitivities, channel_changes};
pub(crate) use fit::effective_dof;
pub use fit::{Found, GlobalFit, global_problem, identify};
pub use free::SeenMark;
pub(crate) use free::step;
pub use marginal::Joint;
pub use marginal::Marginal;
pub use marginal::MarginalProblem;
pub use memory::Evolution;
pub use memory::HysteresisState;
pub use native::NativePredictor;
pub use observation::Evaluation;
pub use observation::NuisanceLayout;
pub use observation::{FrameMotions, Observations, Row};
pub use predictor::CaseChange;
pub use predictor::CaseChanges;
pub use predictor::CasePrediction;
pub use predictor::Observed;
pub use predictor::Prediction;
pub use predictor::Predictor;
pub use prepared::Prepared;
pub(crate) use problem::GlobalProblem;
pub use problem::Watch;
pub use profile::profile_interval;
pub use start_values::{StartValues, fit_unknowns};
pub use study::{Options, Start, fit_study};
pub use unknown::Direction;
pub use unknown::FitUnknown;
pub use unknown::FitUnknowns;
pub use unknown::{Component, Numbers, UnknownTarget};
