//! Backends that solve load cases: the built-in solver, any external program with the command line of ADAMS, and recorded runs of such a
//! program.
//!
//! All backends have the same interface. A request contains a deck, parameter values that differ from the deck, and load cases. The result
//! contains the poses of all parts in each case. Backends do not depend on measurements or on the use of their results.

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
pub use case_sweeper::CaseSweeper;
pub use case_sweeper::Loads;
pub use command::CommandBackend;
pub use compiled::tight_settings;
pub use compiled::{compile, slot};
pub use contract::CaseFailure;
pub(crate) use contract::CaseOutcome;
pub use contract::RunError;
pub use contract::{Backend, BackendError, Sweep, SweepRequest};
pub use deck_run::DeckRun;
pub use deck_run::ProgramRun;
pub use free_motions::FreeMotions;
pub use free_motions::HeldWeight;
pub use free_motions::Twist;
pub use native::NativeBackend;
pub use process::end_runs;
pub use programme::{Load, LoadCase, LoadProgramme};
pub use recording::Recording;
pub use replay::ReplayBackend;
