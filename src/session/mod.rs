//! Executes a command file against a dataset: the drop-in solver.
//!
//! Knows how ADAMS' command line, messages and output files look. Does not know how an equilibrium is found.

mod launcher;
mod located;
mod message;
mod paths;

pub use launcher::{Launch, LaunchInput};
pub use located::{Sources, located};
pub use message::{Messages, exponent};
pub use paths::{WritePolicy, find_file, native_spelling};
