//! Execution of command files by the drop-in solver, and backends with which other crates solve decks.
//!
//! A [`Session`] runs a command file on a dataset and writes the same output files as ADAMS. [`mdi`] is the program with the command line
//! of ADAMS. [`backend`] offers a common interface to the built-in solver, to any external program with the command line of ADAMS, and to
//! recorded runs. [`check`] checks a single file completely.
//!
//! The crate implements the command line, the messages and the output files of ADAMS; it does not depend on measurements.
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
mod program;
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
mod toml_file;
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
pub use program::{own_program, started_by};
pub use toml_file::read_toml;

pub use recorded_commands::recorded_commands;
pub use run_state::Session;
pub use trial::InMemoryRun;
pub use trial::TrialInput;
pub use windows_names::check_name;
