//! Who solves a study: the backend `[solver]` asks for, announced before it runs.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::time::Duration;

use crate::Study;
use crate::settings::BackendChoice;
use admire_session::backend::{Backend, CommandBackend, NativeBackend, Recording, ReplayBackend};
use admire_syntax::diagnostic::{Code, Diagnostic};

use crate::permission::beside;

/// The backend of a study. `keep`: run folders of an external program are made there and stay.
pub fn backend(
    study: &Study,
    keep: Option<PathBuf>,
    tell: &dyn Fn(&Diagnostic),
) -> Box<dyn Backend> {
    match study.solver.backend {
        BackendChoice::Native => Box::new(NativeBackend::new()),
        BackendChoice::Command => Box::new(command(study, keep, tell)),
        BackendChoice::Replay => Box::new(ReplayBackend::new(recording(study))),
    }
}

/// The recorded runs of a study.
pub fn recording(study: &Study) -> Recording {
    Recording::new(study.folder.join(&study.solver.recordings.text))
}

/// The external program of a study. Says which one it is before it is ever started. Whether it may be is the matter of
/// [`permission`](crate::permission).
pub fn command(study: &Study, keep: Option<PathBuf>, tell: &dyn Fn(&Diagnostic)) -> CommandBackend {
    let solver = &study.solver;
    let words = beside(&study.folder, &solver.command);
    let found = words.first().and_then(found_on_path);
    let shown = format!(
        "{} ({})",
        solver.command.join(" "),
        found.map_or_else(
            || "there is no such program here".to_string(),
            |path| path.display().to_string()
        )
    );
    tell(&Diagnostic::note(
        Code::RunsProgram,
        format!("every equilibrium is solved by a program that study.toml names: {shown}"),
    ));
    let mut backend = CommandBackend::new(words, Duration::from_secs_f64(solver.timeout_s));
    backend.licence_wait = Duration::from_secs_f64(solver.licence_wait_s);
    backend.jobs = solver.jobs;
    backend.keep = keep;
    backend
}

/// Where the system finds a program.
pub fn found_on_path(program: impl AsRef<OsStr>) -> Option<PathBuf> {
    which::which(program).ok()
}
