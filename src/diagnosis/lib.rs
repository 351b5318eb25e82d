//! Diagnosis: identification of the errors that remain in a model after its best fit.
//!
//! [`diagnose`](fn@diagnose) finds the causes that probably act, given the readings. Its [`Outcome`] holds the [`Diagnosis`] with the
//! probability of each cause, and the fitted models. The extended model is checked on load cases that no fit used. Each cause is one file in
//! `causes`. [`fit_with_random_effects`] fits a model without causes. [`study_fit`] identifies the stiffnesses of a study by the method that
//! the study names. The crate reads no files. It does not contain the laws by which the virtual rig simulates errors.
//!
//! Modules import in one direction only. In `a <- b`, module `b` imports module `a`. The fit: `diagnosis_problem` (readings and their tolerances)
//! and `candidate_effect` (data) <- `unknowns`, `early_stopping` <- `settle` <- `fit` <- `operating_points` <- `elastic_element` <- `causes`, `site` <- `site_law`.
//! Its linear model and the selection: `reduction` <- `closure` <- `challengers`, `point` <- `fitted_set` <- `set_estimate` <- `select`, with
//! `gaussian_process` <- `remainder` (forces of unknown law) and `model_set` (the result). The checks and the report: `residual_covariance` <-
//! `lack_of_fit` <- `base_fit` <- `selection`, `hold_out_test` <- `hold_out` <- `cross_validation` <- `findings` <- `diagnose`.
#![warn(unreachable_pub)]
// The documentation of private modules links to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

mod averaged;
mod base_fit;
mod candidate_effect;
mod cause;
mod causes;
mod challengers;
mod channel_miss;
mod closure;
mod columns;
mod comparison;
mod corrected_number;
mod cross_validation;
mod deck_only;
mod diagnose;
mod diagnosis;
mod diagnosis_problem;
mod early_stopping;
mod elastic_element;
mod estimate;
mod extended_deck;
mod extension;
mod findings;
mod fit;
mod fitted_set;
mod frame;
mod gain_check;
mod gaussian_process;
mod hold_out;
mod hold_out_test;
mod jackknife;
mod joint_fit;
mod lack_of_fit;
mod limits;
mod model_set;
mod operating_points;
mod other_solver;
mod point;
mod predictive;
pub mod priors;
mod progress;
mod reduction;
mod remainder;
mod residual_covariance;
mod rig_errors;
mod select;
mod selection;
mod set_estimate;
pub mod settings;
mod settle;
mod site;
mod site_law;
mod solver_difference;
pub mod study_fit;
mod trend;
mod unknowns;
/// Progress of long computations, and requests to stop them.
pub mod watch;
mod wheel_run;

pub use base_fit::fit_without_effects;
pub use candidate_effect::CandidateEffect;
pub use cause::Cause;
pub use causes::progressive_stiffness::{
    LARGEST_DEFLECTION, LARGEST_RADIAL_DEFLECTION, STIFFNESS_RISES, spline_terms,
};
pub use channel_miss::ChannelMiss;
pub use corrected_number::CorrectedNumber;
pub use cross_validation::{CrossValidation, GroupGain};
pub use deck_only::DeckOnlyPrediction;
pub use diagnose::{Outcome, Rival, diagnose, diagnose_watched, held_out};
pub use diagnosis::{
    BaselineFit, CauseLimit, DetectionLimit, Diagnosis, Evidence, Finding, Gain, Indistinguishable,
    LAW_MISFIT, NextMeasurement, NoiseFound, Parameter, ToleranceFound, Unexplained, Verdict,
};
pub use diagnosis_problem::{Data, DiagnosisProblem};
pub use fit::with_zero_guesses;
pub use fit::{Estimate, FittedModel};
pub use frame::{at_point, by_frame, centroid, motions};
pub use gain_check::GainCheck;
pub use hold_out::{HoldOut, HoldOutSelection};
pub use hold_out_test::{HeldOutTest, HoldOutPrediction};
pub use joint_fit::{JointFit, fit_with_random_effects};
pub use limits::{cause_limits, detection_limits};
pub use model_set::{ModelSet, Selected};
pub use progress::Progress;
pub use remainder::{Over, Predicted, Remainder, RemainderPoint};
pub use selection::selected;
pub use solver_difference::SolverDifference;
pub use trend::Trend;
pub use unknowns::{Known, Unknowns};
pub use watch::{ProgressObserver, ProgressSnapshot, SharedProgress};
pub use wheel_run::WheelRun;
