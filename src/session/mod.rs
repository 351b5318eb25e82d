//! Executes a command file against a dataset: the drop-in solver.
//!
//! Knows how ADAMS' command line, messages and output files look. Does not know how an equilibrium is found.

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
pub(crate) use file_below::file_below;
pub(crate) use file_policy::FilePolicy;
pub use files::folder_of;
pub(crate) use files::read_files;

pub use located::Sources;
pub(crate) use located::located;
pub use mdi::mdi;
pub use message::exponent;
pub use moment::Moment;
pub(crate) use on_deck::on_deck;
pub(crate) use paths::{find_file, native_spelling};

pub(crate) use recorded_commands::recorded_commands;
pub use run_state::Session;
pub use trial::Trial;
pub(crate) use trial::TrialInput;
pub(crate) use windows_names::check_name;
