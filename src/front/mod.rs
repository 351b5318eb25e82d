//! Front of the library: a deck, its runs, studies and results files, each as a type with a few methods.
//!
//! The Python package and the subcommands use the same functions, so the library, Python and the command line give the same results.

mod assignment;
#[cfg(feature = "kc")]
mod axle;
#[cfg(feature = "report")]
mod car_elements;
pub(crate) mod car_files;
#[cfg(feature = "report")]
pub(crate) mod check_page;
mod commands;
#[cfg(feature = "report")]
pub(crate) mod compare_page;
mod deck;
mod deck_edits;
mod error;
#[cfg(feature = "report")]
pub(crate) mod fit_view;
#[cfg(feature = "report")]
mod foreign;
#[cfg(feature = "kc")]
mod kc_measured;
#[cfg(feature = "kc")]
mod kc_page;
#[cfg(feature = "python")]
mod mechanism_page;
pub(crate) mod permissions;
mod persist;
#[cfg(feature = "report")]
pub(crate) mod plan_page;
mod results;
mod run;
mod sensitivity;
#[cfg(feature = "report")]
mod study;
#[cfg(feature = "report")]
mod suggested;
#[cfg(test)]
mod tests;
#[cfg(feature = "kc")]
mod tune_page;
#[cfg(feature = "kc")]
pub(crate) mod tuning;
mod unit_words;
mod value;
mod writing;

pub use admire_diagnosis::{ProgressObserver, ProgressSnapshot, SharedProgress};
pub(crate) use assignment::{Before, beyond, edits, new_errors, structure_digest};
#[cfg(feature = "kc")]
pub use axle::{AxleTests, Beside};
pub use commands::{Command, Commands};
pub use deck::{Deck, Setting};
pub(crate) use deck_edits::{
    edited, kind_with_ids, moving_parts, no_statement, removal, with_statements,
};
pub use error::{Complaint, Error, ErrorKind, Place};
#[cfg(feature = "report")]
pub(crate) use foreign::foreign_parts;
#[cfg(feature = "kc")]
pub(crate) use kc_measured::measured;
#[cfg(feature = "kc")]
pub(crate) use kc_page::{KcDeck, kc_page};
#[cfg(feature = "python")]
pub(crate) use mechanism_page::compared;
pub use results::{Results, Rows};
pub use run::Run;
pub(crate) use sensitivity::Unavailable;
pub use sensitivity::{SensitivityRow, SensitivityTable};
#[cfg(feature = "report")]
pub use study::{DiagnosisAnswer, Identification, PlanAnswer, Study};
#[cfg(feature = "report")]
pub(crate) use suggested::suggested;
#[cfg(feature = "kc")]
pub(crate) use tune_page::tune_page;
#[cfg(feature = "kc")]
pub use tuning::{TuningAnswer, TuningOptions};
pub(crate) use unit_words::units;
pub(crate) use value::{is_angle, rounded, value};
pub(crate) use writing::{replace_file, take_place};
