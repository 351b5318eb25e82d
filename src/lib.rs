//! `admire`: an ADAMS-compatible file toolkit and drop-in solver.
//!
//! It reads, edits, checks and writes ADAMS datasets (`.adm`), command files (`.acf`) and results (`.res`), solves the same decks
//! for static equilibrium, identifies bushing stiffnesses from measured part displacements, and says what a model still gets
//! wrong.
//!
//! # First steps
//!
//! ```
//! use admire::Deck;
//!
//! # fn main() -> Result<(), admire::Error> {
//! let before = Deck::open("corpus/pseudo-mcpherson/model.adm")?.set("SFORCE/1", 1000.0)?.solve()?;
//! let after = Deck::open("corpus/pseudo-mcpherson/model.adm")?
//!     .set("SFORCE/1", 1000.0)?
//!     .set("BUSHING/*.K.1", 20_000.0)?
//!     .solve()?;
//! // A value per step: the deck as it was read, then the equilibrium.
//! let (soft, stiff) = (before.column("front_arm.X")?, after.column("front_arm.X")?);
//! assert!((stiff[1] - stiff[0]).abs() < (soft[1] - soft[0]).abs());
//! # Ok(())
//! # }
//! ```
//!
//! A [`Deck`] reads, changes, checks and saves a dataset, finds its equilibrium and executes command files; a [`Run`] holds what files would.
//! [`Results`] reads results files of any size. A [`Study`] identifies stiffnesses and diagnoses:
//!
//! ```
//! use admire::{SharedProgress, Study};
//!
//! # fn main() -> Result<(), admire::Error> {
//! let answer = Study::open("corpus/pseudo-mcpherson")?.identify(false, &SharedProgress::default())?;
//! let first = &answer.fit.parameters[0];
//! assert_eq!(first.address, "BUSHING/1.K.1");
//! // The true stiffness of the shipped study.
//! assert!((first.value - 13875.0).abs() < 4.0 * first.std_error.expect("an identified number has one"));
//! # Ok(())
//! # }
//! ```
//!
//! # The ladder: one word, one owner, one direction
//!
//! ```text
//! bytes -> Source -> tokens -> Dataset -> lower -> Model -> compile -> System + Parameters -> newton(State) -> Equilibrium
//!                     ^ Edit <- editor <- Address <- Origin                                         |
//!                     |                                                                             v
//!                     +-- edited bytes + .acf -> external ADAMS -> .res/.msg ------------> Equilibrium (same type)
//! Measurement -> identify(theta) -> Edits (one-line diffs) -> new Dataset
//! Fit + Measurement -> diagnosis -> Findings -> extended Dataset -> gain on held-out load cases
//! ```
//!
//! # Crates
//!
//! From the bottom up; a crate uses those above it in this list only, and each can be taken alone. The commands, the Python package and
//! this front use them all.
//!
//! | crate | what it owns |
//! |---|---|
//! | `admire-guide` | the pages of the guide, text only |
//! | `admire-syntax` | datasets and command files as text, units, grammar, complaints |
//! | `admire-results` | results files: readers and writers |
//! | `admire-solver` | model, laws, joints, equations, equilibrium, motion |
//! | `admire-session` | command files executed, backends, the check of one file |
//! | `admire-study` | study files, marks, readings |
//! | `admire-rig` | the virtual rig, planted effects |
//! | `admire-kc` | standard tests and characteristics of an axle |
//! | `admire-identify` | regression, direct, Gauss-Newton; tolerances of axle and rig |
//! | `admire-diagnosis` | causes, search, extension, gain |
//! | `admire-design` | what to measure next |
//! | `admire-report` | HTML and SVG |
//! | `admire-lsp` | the language server |
//! | `admire-sweep` | variants and identifications by the thousand |
//!
//! Features: `cli` (the command `admire`), `lsp`, `sweep`, on by default; `python` (the Python package).
#![warn(unreachable_pub)]
// Rooms that are hidden or private link to what is private with them.
#![allow(rustdoc::private_intra_doc_links)]
// Some of the front is for the commands alone.
#![cfg_attr(not(feature = "cli"), allow(dead_code))]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
mod front;
#[cfg(feature = "python")]
mod python;

pub use admire_design::Aim;
pub use admire_diagnosis::GainCheck;
#[doc(inline)]
pub use admire_guide as guide;
pub use admire_kc::Convention;
pub use admire_results::{Header, ResultUnits, SelectedColumn, StepFilter, StepKind};
pub use admire_session::{Ending, Stop};
pub use admire_study::settings::Method;
pub use admire_syntax::diagnostic::{Code, Severity};
pub use admire_syntax::diff::{Change, Difference, Tolerance};
pub use front::{
    AxleTests, Beside, Command, Commands, Complaint, Deck, DiagnosisAnswer, Error, ErrorKind,
    Identification, Place, PlanAnswer, ProgressObserver, ProgressSnapshot, Results, Rows, Run,
    SensitivityRow, SensitivityTable, Setting, SharedProgress, Study,
};

/// What an [`Identification`] holds: the types of `identification.json`.
pub mod fit {
    pub use admire_identify::{
        BootstrapMade, ChiSquare, CurveHeldOut, Fit, FitTest, HeldOut, LackOfFitAspect,
        LackOfFitTest, Marks, NoiseFound, OffsetFit, ParameterFit, PosteriorMade, ReadingsLeft,
        Repeated, Status, ToleranceFound, UnidentifiableDirection, Verdict, WheelFit, Written,
    };
    pub use admire_solver::statics::{Balance, Left};
    pub use admire_solver::system::Name;
}

/// What a [`DiagnosisAnswer`] holds: the types of `diagnosis.json`.
pub mod diagnosis {
    pub use admire_diagnosis::{
        BaselineFit, Cause, CauseLimit, CrossValidation, DetectionLimit, Diagnosis, Evidence,
        Finding, Gain, GroupGain, HoldOut, Indistinguishable, NextMeasurement, Over, Parameter,
        Predicted, Remainder, RemainderPoint, SolverDifference, Unexplained, Verdict,
    };
    pub use admire_identify::{NoiseFound, Status, ToleranceFound};
}

/// What a [`PlanAnswer`] holds: the types of `plan.json`.
pub mod plan {
    pub use admire_design::{
        Combination, Curves, Kind, Plan, Ranked, Separation, Undecided, WheelSd,
    };
    pub use admire_diagnosis::{CauseLimit, DetectionLimit};
}
