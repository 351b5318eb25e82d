//! `admire`: an ADAMS-compatible file toolkit and drop-in solver.
//!
//! It reads, edits, checks and writes ADAMS datasets (`.adm`), command files (`.acf`) and results (`.res`). It solves the same decks for
//! static equilibrium, identifies bushing stiffnesses from measured part displacements, and diagnoses the remaining faults of a model.
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
//! A [`Deck`] reads, changes, checks and saves a dataset, finds its equilibrium and executes command files. A [`Run`] contains the contents
//! of the output files. [`Results`] reads results files of any size. A [`Study`] identifies stiffnesses and diagnoses the model:
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
//! # From bytes to results
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
//! The crates are listed from the bottom up. Each uses only crates above it in this list, and can be used alone. The commands, the Python
//! package and this front use all of them.
//!
//! | crate | contents |
//! |---|---|
//! | `admire-guide` | the pages of the guide, text only |
//! | `admire-syntax` | datasets and command files as text, units, grammar, diagnostics |
//! | `admire-car` | property, subsystem and assembly files of Adams/Car |
//! | `admire-results` | results files: readers and writers |
//! | `admire-solver` | model, laws, joints, equations, equilibrium, motion |
//! | `admire-session` | execution of command files, backends, checks of single files |
//! | `admire-study` | study files, marks, readings |
//! | `admire-rebuild` | decks and studies out of results files |
//! | `admire-rig` | the virtual rig, planted effects |
//! | `admire-kc` | standard tests and characteristics of an axle |
//! | `admire-lab` | tables of K&C laboratories, mapped into curves and load cases |
//! | `admire-identify` | regression, direct, Gauss-Newton; tolerances of axle and rig |
//! | `admire-tune` | numbers of a deck that give wanted characteristics |
//! | `admire-diagnosis` | causes, search, extension, gain |
//! | `admire-design` | planning of further measurements |
//! | `admire-report` | HTML and SVG |
//! | `admire-lsp` | the language server |
//! | `admire-sweep` | sweeps over variants of a deck, repeated identifications |
//!
//! Features, on by default: `cli` (the command `admire`), `kc` (tests of an axle), `report` (studies with their pages), `lsp`, `sweep`. Off by
//! default: `python` (the Python package).
#![warn(unreachable_pub)]
// Private and hidden modules link to their private items.
#![allow(rustdoc::private_intra_doc_links)]
// Some items of `front` are used only by the command line, and are unused without it.
#![cfg_attr(not(feature = "cli"), allow(dead_code))]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
mod front;
#[cfg(feature = "python")]
mod python;

#[cfg(feature = "report")]
pub use admire_design::Aim;
pub use admire_diagnosis::GainCheck;
#[doc(inline)]
pub use admire_guide as guide;
#[cfg(feature = "kc")]
pub use admire_kc::Convention;
pub use admire_results::{Header, ResultUnits, SelectedColumn, StepFilter, StepKind};
pub use admire_session::{Ending, Stop};
pub use admire_study::settings::Method;
pub use admire_syntax::diagnostic::{Code, Severity};
pub use admire_syntax::diff::{DiffKind, DiffTolerance, Difference};
#[cfg(feature = "kc")]
pub use front::{AxleTests, Beside, TuningAnswer, TuningOptions};
pub use front::{
    Command, Commands, Complaint, Deck, Error, ErrorKind, Place, ProgressObserver,
    ProgressSnapshot, Results, Rows, Run, SensitivityRow, SensitivityTable, Setting,
    SharedProgress,
};
#[cfg(feature = "report")]
pub use front::{DiagnosisAnswer, Identification, PlanAnswer, Study};

/// Contents of an [`Identification`]: the types of `identification.json`.
pub mod fit {
    pub use admire_identify::{
        BootstrapMade, ChiSquare, CurveHeldOut, Fit, FitTest, FitVerdict, HeldOut, LackOfFitAspect,
        LackOfFitTest, Marks, NoiseFound, OffsetFit, ParameterFit, PosteriorMade, ReadingsLeft,
        Repeated, Status, ToleranceFound, UnidentifiableDirection, WheelFit, Written,
    };
    pub use admire_solver::statics::{Balance, Left};
    pub use admire_solver::system::Name;
}

/// Contents of a [`DiagnosisAnswer`]: the types of `diagnosis.json`.
pub mod diagnosis {
    pub use admire_diagnosis::{
        BaselineFit, Cause, CauseLimit, CrossValidation, DetectionLimit, Diagnosis, Evidence,
        Finding, Gain, GroupGain, HoldOut, Indistinguishable, NextMeasurement, Over, Parameter,
        Predicted, Remainder, RemainderPoint, SolverDifference, Unexplained, Verdict,
    };
    pub use admire_identify::{NoiseFound, Status, ToleranceFound};
}

/// Contents of a [`PlanAnswer`]: the types of `plan.json`.
pub mod plan {
    pub use admire_design::{
        Combination, Curves, Kind, Plan, Ranked, Separation, Undecided, WheelSd,
    };
    pub use admire_diagnosis::{CauseLimit, DetectionLimit};
}
