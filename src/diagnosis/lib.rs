//! Diagnosis: what a model gets wrong after its best fit.
//!
//! [`diagnose`](fn@diagnose) searches the causes that the readings ask for and returns an [`Outcome`]: the [`Diagnosis`] with probabilities, and the fits behind
//! it. The extended model is checked on load cases that no fit saw. Each cause is one file in `causes`. [`tolerant`](fn@tolerant) is the fit of a sound model
//! among tolerances, [`study_fit`] the identification of a study by its own method. Knows no files, and not the laws by which the virtual rig
//! plants effects.
//!
//! One direction: `subject` (what was read, and its tolerances) and `hypothesis` (data) <- `unknowns`, `aim` <- `settle` <- `fit` <- `survey` <-
//! `causes`, `columns` <- `scan` <- `search` (`stand_in` adds forces of unknown laws to it; `rig_errors` may end it) <- `sought`, `foreseen` <- `folds` <- `unseen` <- `cross_validation`,
//! `structure`, `gaussian_process` <- `remainder`, `averaged` <- `findings` <- `searched` <- `diagnose`, and what shows its outcome.
#![warn(unreachable_pub)]
// Modules that are private link to what is private with them.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

mod aim;
mod averaged;
mod cause;
mod causes;
mod channel_miss;
mod columns;
mod comparison;
mod cross_validation;
mod diagnose;
mod diagnosis;
mod diagnosis_problem;
mod ends;
mod estimate;
mod extended_deck;
mod extension;
mod findings;
mod fit;
mod folds;
mod frame;
mod gain_check;
mod gaussian_process;
mod hold_out;
mod hypothesis;
mod influence;
mod jackknife;
mod joint_fit;
mod limits;
mod other_solver;
mod predictive;
mod progress;
mod remainder;
mod rig_errors;
mod scan;
mod search;
mod searched;
mod settle;
mod solver_difference;
mod sought;
mod stand_in;
mod stiffness;
mod structure;
pub mod study_fit;
mod survey;
mod tolerance_words;
mod trend;
mod tried;
mod unknowns;
mod visited;
/// Progress of long computations, and how they are stopped.
pub mod watch;
mod wheel_run;
mod words;

pub use cause::Cause;
pub use channel_miss::ChannelMiss;
pub use cross_validation::{CrossValidation, GroupGain};
pub use diagnose::{Outcome, Rival, diagnose, diagnose_watched, held_out};
pub use diagnosis::{
    BaselineFit, CauseLimit, DetectionLimit, Diagnosis, Evidence, Finding, Gain, Indistinguishable,
    NextMeasurement, NoiseFound, Parameter, ToleranceFound, Unexplained, Verdict,
};
pub use diagnosis_problem::{Data, DiagnosisProblem};
pub use fit::with_zero_guesses;
pub use fit::{DeckOnlyPrediction, Estimate, FittedModel};
pub use folds::{Blind, HeldOutTest};
pub use frame::{at_point, by_frame, centroid, motions};
pub use gain_check::GainCheck;
pub use hold_out::{HoldOut, HoldOutSelection};
pub use hypothesis::Hypothesis;
pub use joint_fit::{JointFit, fit_with_random_effects};
pub use limits::{cause_limits, detection_limits};
pub use progress::Progress;
pub use remainder::{Over, Predicted, Remainder, RemainderPoint};
pub use solver_difference::SolverDifference;
pub use sought::{as_it_is, seek};
pub use stiffness::CorrectedStiffness;
pub use structure::StructureTest;
pub use trend::Trend;
pub use unknowns::{Known, Unknowns};
pub use visited::{Found, Visited};
pub use watch::{ProgressObserver, ProgressSnapshot, SharedProgress};
pub use wheel_run::WheelRun;
