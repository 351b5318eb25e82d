//! Creation of the solver backend of a study, as chosen in `[solver]`.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::time::Duration;

use crate::Study;
use crate::settings::BackendChoice;
use admire_session::backend::{Backend, CommandBackend, NativeBackend, Recording, ReplayBackend};
use admire_syntax::diagnostic::{Code, Diagnostic};

use crate::permission::beside;

/// Returns the solver backend of a study. If `keep` is given, the run folders of an external program are created in this folder and kept. For
/// an external program, `tell` receives a note that names it.
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

/// Returns the recorded solver runs of a study.
pub fn recording(study: &Study) -> Recording {
    Recording::new(study.folder.join(&study.solver.recordings.text))
}

/// Returns the backend that runs the external program of a study. A note that names the program is passed to `tell`. Whether the program may be
/// started is decided in [`permission`](crate::permission).
pub fn command(study: &Study, keep: Option<PathBuf>, tell: &dyn Fn(&Diagnostic)) -> CommandBackend {
    let solver = &study.solver;
    let words = beside(&study.folder, &solver.command);
    let found = words.first().and_then(found_on_path);
    let shown = format!(
        "{} ({})",
        solver.command.join(" "),
        found.map_or_else(
            || "not found on this computer".to_string(),
            |path| path.display().to_string()
        )
    );
    tell(&Diagnostic::note(
        Code::RunsProgram,
        format!("the program named in study.toml solves every equilibrium: {shown}"),
    ));
    let mut backend = CommandBackend::new(words, Duration::from_secs_f64(solver.timeout_s));
    backend.licence_wait = Duration::from_secs_f64(solver.licence_wait_s);
    backend.jobs = solver.jobs;
    backend.keep = keep;
    backend
}

/// Returns the path of a program found in the directories of PATH, or `None`.
pub fn found_on_path(program: impl AsRef<OsStr>) -> Option<PathBuf> {
    which::which(program).ok()
}
