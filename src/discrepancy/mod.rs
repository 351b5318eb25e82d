//! Discrepancy: what a model gets wrong after its best fit, named with probability, modelled and measured on load cases no fit saw.
//!
//! Knows no files: a study's problem comes in, a diagnosis and the fits behind it go out. The laws by which effects are planted on
//! the virtual rig are not known here.
//!
//! One direction: `subject` (what was read, and its tolerances) and `hypothesis` (data) <- `unknowns`, `aim` <- `settle` <- `fit` <- `survey` <-
//! `causes`, `columns` <- `scan` <- `search` (`stand_in` adds forces of unknown laws to it; `rig_errors` may end it) <- `sought`, `foreseen` <- `folds` <- `unseen` <- `cross_validation`,
//! `structure`, `gaussian_process` <- `remainder`, `averaged` <- `findings` <- `searched` <- `diagnose`, and what shows its outcome.
//! What could be measured next goes beside: `candidate` <- `forecast` <- `prospect` <- `information` <- `rivals` <- `next_measurement`, `plan`.

mod aim;
mod averaged;
mod candidate;
mod cause;
mod causes;
mod channel_miss;
mod columns;
mod comparison;
mod cross_validation;
mod diagnose;
mod diagnosis;
mod ends;
mod extended_deck;
mod extension;
mod findings;
mod fit;
mod folds;
mod forecast;
mod foreseen;
mod frame;
mod gain_check;
mod gaussian_process;
mod hypothesis;
mod influence;
mod information;
mod jackknife;
mod limits;
mod next_measurement;
mod other_solver;
mod plan;
mod progress;
mod prospect;
mod remainder;
mod rig_errors;
mod rivals;
mod scan;
mod search;
mod searched;
mod settle;
mod solver_difference;
mod sought;
mod stand_in;
mod stiffness;
mod structure;
mod subject;
mod survey;
mod tolerance_words;
mod tolerant;
mod trend;
mod tried;
mod unknowns;
mod unseen;
mod visited;
mod wheel_place;
mod wheel_run;
mod words;

pub use candidate::Kind;
pub use cause::Cause;
pub use channel_miss::ChannelMiss;
pub use cross_validation::{CrossValidation, GroupGain};
pub use diagnose::{Outcome, diagnose, diagnose_watched, held_out};
pub use diagnosis::{
    BaselineFit, CauseLimit, DetectionLimit, Diagnosis, Evidence, Finding, Gain, Indistinguishable,
    NextMeasurement, NoiseFound, Parameter, ToleranceFound, Unexplained, Verdict,
};
pub use fit::{Estimate, Fitted, Plain};
pub use folds::{Blind, HeldOutTest};
pub use gain_check::GainCheck;
pub use hypothesis::Hypothesis;
pub use plan::{Aim, Combination, Curves, Plan, Ranked, Undecided, WheelSd, plan};
pub use progress::Progress;
pub use remainder::{Over, Predicted, Remainder, RemainderPoint};
pub use rivals::Separation;
pub use solver_difference::SolverDifference;
pub use stiffness::CorrectedStiffness;
pub use structure::StructureTest;
pub use subject::{Data, Subject};
pub use tolerant::{Tolerant, tolerant};
pub use trend::Trend;
pub use unseen::{HoldOut, Unseen};
pub use wheel_run::WheelRun;
