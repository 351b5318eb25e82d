//! Who solves: the built-in solver, any program with ADAMS' command line, or a recording of one of them.
//!
//! One contract for all: a dataset, numbers of it that change between runs, load cases; back come part poses. Knows nothing
//! about measurements and about what the answers are used for.

mod answer;
mod bushing_check;
mod case_check;
mod case_sweeper;
mod command;
mod compiled;
mod contract;
mod deck_run;
mod free_motions;
#[cfg(windows)]
mod job;
mod licence;
mod native;
mod process;
#[cfg(not(windows))]
mod process_tree;
mod programme;
mod recording;
mod replay;
mod run_folder;
mod scratch_folder;

pub use bushing_check::ForceFrame;
pub(crate) use case_sweeper::CaseSweeper;
pub use case_sweeper::Loads;
pub use command::CommandBackend;
pub(crate) use compiled::tight_settings;
pub use compiled::{compile, slot};
pub use contract::{Backend, BackendError, Sweep, SweepRequest};
pub(crate) use contract::{CaseFailure, CaseOutcome, RunError};
pub(crate) use deck_run::{DeckRun, ProgramRun};
pub use free_motions::FreeMotions;
pub(crate) use free_motions::{HeldWeight, Twist};
pub use native::NativeBackend;
pub(crate) use process::end_runs;
pub use programme::{Load, LoadCase, LoadProgramme};
pub use recording::Recording;
pub use replay::ReplayBackend;
