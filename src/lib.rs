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
//! use admire::{Study, Watched};
//!
//! # fn main() -> Result<(), admire::Error> {
//! let answer = Study::open("corpus/pseudo-mcpherson")?.identify(false, &Watched::default())?;
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
//! Fit + Measurement -> discrepancy -> Findings -> extended Dataset -> gain on held-out load cases
//! ```
//!
//! # Floors
//!
//! A module uses only lower floors; on the same floor there is no edge. `tests/architecture.rs` reads this table and holds
//! every `use crate::` line to it.
//!
//! | floor | module | what it owns |
//! |---|---|---|
//! | 0 | text | bytes, spans, edits |
//! | 0 | units | units of a dataset, dimensions |
//! | 0 | guide | the pages of the guide, text only |
//! | 0 | mechanics | pose, rotation, relative motion |
//! | 0 | linear | sparse matrix, LU factors, their order |
//! | 1 | diagnostic | what to tell a person, as data |
//! | 2 | grammar | statements, commands and functions as tables |
//! | 3 | syntax | lexer, dataset, command file, expressions, addresses, editor, lint |
//! | 3 | results | .res, .req: readers and writers |
//! | 4 | model | resolved, typed, named objects |
//! | 5 | function | compiled FUNCTION expressions |
//! | 6 | element | force laws |
//! | 6 | constraint | joints and primitives |
//! | 7 | system | compile, assemble, parameters, state |
//! | 8 | statics | equilibrium, sensitivities, report |
//! | 8 | motion | initial conditions, kinematics, integration over time |
//! | 9 | session | executes a command file: the drop-in solver |
//! | 10 | check | everything there is to say of one file |
//! | 10 | backend | who solves: native, external command, replay |
//! | 11 | kc | standard tests and characteristics of an axle |
//! | 12 | rig | marks, orientation, load cases, noise, planted effects |
//! | 13 | tolerance | noise of readings, tolerances of axle and rig, evidence |
//! | 14 | identify | regression, direct, Gauss-Newton |
//! | 15 | discrepancy | causes, search, extension, gain |
//! | 16 | report | HTML and SVG |
//! | 17 | lsp | the language server |
//! | 17 | front | a deck, its runs, studies, results: what most programs need |
//! | 18 | sweep | variants by the thousand: cases, shards, the table of answers |
//! | 19 | uncertainty | identifications by the thousand: bootstrap, sampled posterior |
//! | 20 | cli | subcommands |
//! | 20 | python | the Python package |
#![warn(unreachable_pub)]
// Rooms that are hidden or private link to what is private with them.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

#[doc(hidden)]
pub mod backend;
#[doc(hidden)]
pub mod check;
#[doc(hidden)]
pub mod cli;
mod constraint;
#[doc(hidden)]
pub mod diagnostic;
#[doc(hidden)]
pub mod discrepancy;
mod element;
mod front;
#[doc(hidden)]
pub mod function;
#[doc(hidden)]
pub mod grammar;
pub mod guide;
#[doc(hidden)]
pub mod identify;
#[doc(hidden)]
pub mod kc;
mod linear;
#[doc(hidden)]
pub mod lsp;
#[doc(hidden)]
pub mod mechanics;
#[doc(hidden)]
pub mod model;
#[doc(hidden)]
pub mod motion;
#[cfg(feature = "python")]
mod python;
#[doc(hidden)]
pub mod report;
#[doc(hidden)]
pub mod results;
#[doc(hidden)]
pub mod rig;
#[doc(hidden)]
pub mod session;
#[doc(hidden)]
pub mod statics;
#[doc(hidden)]
pub mod sweep;
#[doc(hidden)]
pub mod syntax;
#[doc(hidden)]
pub mod system;
#[doc(hidden)]
pub mod text;
mod tolerance;
mod uncertainty;
#[doc(hidden)]
pub mod units;

pub use diagnostic::{Code, Severity};
pub use discrepancy::{Aim, GainCheck};
pub use front::{
    AxleTests, Beside, Complaint, Deck, DiagnosisAnswer, Error, ErrorKind, Identification, Place,
    PlanAnswer, Results, Rows, Run, SensitivityRow, SensitivityTable, Setting, Stand, Study, Watch,
    Watched,
};
pub use kc::Convention;
pub use results::{Header, ResultUnits, SelectedColumn, StepFilter, StepKind};
pub use rig::settings::Method;
pub use session::{Ending, Stop};
pub use syntax::diff::{Change, Difference, Tolerance};

/// What an [`Identification`] holds: the types of `identification.json`.
pub mod fit {
    pub use crate::identify::structure::StructureTest;
    pub use crate::identify::{
        BootstrapMade, CurveHeldOut, Fit, FitTest, HeldOut, Marks, NoiseFound, OffsetFit,
        ParameterFit, PosteriorMade, ReadingsLeft, Repeated, Status, ToleranceFound,
        UnidentifiableDirection, Verdict, WheelFit, Written,
    };
    pub use crate::statics::{Balance, Left};
    pub use crate::system::Name;
}

/// What a [`DiagnosisAnswer`] holds: the types of `diagnosis.json`.
pub mod diagnosis {
    pub use crate::discrepancy::{
        BaselineFit, Cause, CauseLimit, CrossValidation, DetectionLimit, Diagnosis, Evidence,
        Finding, Gain, GroupGain, HoldOut, Indistinguishable, NextMeasurement, Over, Parameter,
        Predicted, Remainder, RemainderPoint, SolverDifference, Unexplained, Verdict,
    };
    pub use crate::identify::{NoiseFound, Status, ToleranceFound};
}

/// What a [`PlanAnswer`] holds: the types of `plan.json`.
pub mod plan {
    pub use crate::discrepancy::{
        CauseLimit, Combination, Curves, DetectionLimit, Kind, Plan, Ranked, Separation, Undecided,
        WheelSd,
    };
}
