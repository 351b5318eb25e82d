//! Front of the library: a deck, its runs, studies and results files, each with a few methods.
//!
//! The Python package and the subcommands use the same functions, so that all three give the same results.

mod assignment;
mod axle;
mod deck;
mod deck_edits;
mod error;
pub(crate) mod fit_view;
mod foreign;
mod kc_measured;
mod kc_page;
pub(crate) mod permissions;
mod persist;
mod results;
mod run;
mod sensitivity;
mod study;
mod suggested;
#[cfg(test)]
mod tests;
mod unit_words;
mod value;
mod writing;

pub use admire_diagnosis::{ProgressObserver, ProgressSnapshot, SharedProgress};
pub(crate) use assignment::{Before, edits, new_errors, outline};
pub use axle::{AxleTests, Beside};
pub use deck::{Deck, Setting};
pub(crate) use deck_edits::{
    edited, kind_with_ids, moving_parts, no_statement, removal, with_statements,
};
pub use error::{Complaint, Error, ErrorKind, Place};
pub(crate) use foreign::foreign_parts;
pub(crate) use kc_measured::measured;
pub(crate) use kc_page::kc_page;
pub use results::{Results, Rows};
pub use run::Run;
pub(crate) use sensitivity::Unavailable;
pub use sensitivity::{SensitivityRow, SensitivityTable};
pub use study::{DiagnosisAnswer, Identification, PlanAnswer, Study};
pub(crate) use suggested::suggested;
pub(crate) use unit_words::units;
pub(crate) use value::{is_angle, rounded, value};
pub(crate) use writing::{replace_file, take_place};
