//! Who solves: the built-in solver, any program with ADAMS' command line, or a recording of one of them.
//!
//! One contract for all: a dataset, numbers of it that change between runs, load cases; back come part poses. Knows nothing
//! about measurements and about what the answers are used for.

mod command;
mod contract;
mod native;
mod programme;
mod run_folder;

pub use command::CommandBackend;
pub use contract::{
    Backend, BackendError, CaseFailure, CaseOutcome, RunError, Sweep, SweepRequest,
};
pub use native::{NativeBackend, compile, slot, tight_settings};
pub use programme::{Load, LoadCase, LoadProgramme};
