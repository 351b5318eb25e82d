//! Execution of command files: the drop-in solver, and the backends for other crates that solve decks.
//!
//! A [`Session`] runs a command file against a dataset and writes the output files of ADAMS; [`mdi`] is the program with ADAMS' command line.
//! [`backend`] has one contract for all solvers: the built-in one, any program with ADAMS' command line, and recorded runs. [`check`] runs all
//! checks of one file. The crate implements ADAMS' command line, messages and output files, and is independent of measurements.
#![warn(unreachable_pub)]
// The documentation of private modules links to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

pub mod backend;
pub mod check;
mod columns;
mod ending;
mod file_below;
mod file_policy;
mod files;
mod gathered;
mod graphics;
mod harmless;
mod launcher;
mod linear;
mod listing;
mod loaded;
mod located;
mod mdi;
mod measures;
mod message;
mod moment;
mod object_names;
mod on_deck;
mod output_options;
mod outputs;
mod paths;
mod progress;
mod record;
mod recorded_commands;
mod run;
mod run_state;
mod saved;
mod saving;
mod sensing;
mod simulate;
mod simulation;
mod starting;
mod transient;
mod trial;
mod watching;
mod windows_names;

pub use ending::{Ending, Stop};
pub use file_below::file_below;
pub use file_policy::FilePolicy;
pub use files::folder_of;
pub use files::read_files;

pub use located::Sources;
pub use located::located;
pub use mdi::mdi;
pub use message::exponent;
pub use moment::Moment;
pub use on_deck::commands_for_other_model;
pub use paths::find_file;
pub(crate) use paths::native_spelling;

pub use recorded_commands::recorded_commands;
pub use run_state::Session;
pub use trial::InMemoryRun;
pub use trial::TrialInput;
pub use windows_names::check_name;
