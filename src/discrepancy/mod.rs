//! Discrepancy: what a model gets wrong after its best fit, named, modelled and measured on load cases no fit saw.
//!
//! Knows no files: a study's problem comes in, a diagnosis and the fits behind it go out. The laws by which effects are planted on
//! the virtual rig are not known here.

mod background;
mod cause;
mod columns;
mod diagnose;
mod diagnosis;
mod effort;
mod exchange;
mod extended;
mod extension;
mod fit_problem;
mod held_out;
mod hypothesis;
mod influence;
mod next_measurement;
mod outside;
mod screening;
mod selection;
mod setup;
mod stiffness;
mod structure;
mod subject;
mod survey;
mod trend;
mod wheel_run;
mod words;

pub use cause::Cause;
pub use diagnose::{Outcome, diagnose, held_out};
pub use diagnosis::{
    BaselineFit, Diagnosis, Evidence, Finding, Gain, Indistinguishable, NextMeasurement,
    Unexplained, Verdict,
};
pub use extended::{Estimate, Fitted};
pub use held_out::{HeldOutTest, held_out_test, marks_gain};
pub use hypothesis::Hypothesis;
pub use stiffness::CorrectedStiffness;
pub use structure::StructureTest;
pub use subject::{Data, Subject};
pub use trend::Trend;
pub use wheel_run::WheelRun;
