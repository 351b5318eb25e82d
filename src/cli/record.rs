use std::path::PathBuf;

use admire_diagnosis::study_fit::fitted;
use admire_session::backend::Recording;
use admire_study::settings::BackendChoice;
use admire_study::{permission::NamedProgram, solver};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::counted::counted;
use super::identify::MethodChoice;
use super::input::study;
use super::interrupt;
use super::permission::Permission;
use super::progress::Progress;
use super::shell::{Exit, Shell};

/// Record the runs of a study's external solver, so that `backend = "replay"` can use them without the solver.
///
/// The study is identified as by `admire identify` with `backend = "command"`. Each run with a result is stored with its deck, command
/// file, results and messages, under a key from the contents of the deck and the command file. Nothing else is written.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire record my-axle\n  admire record my-axle --into recordings"
)]
pub(super) struct Arguments {
    /// Folder of the study.
    study: PathBuf,
    /// Folder for the recorded runs, instead of the study's own `[solver] recordings`.
    #[arg(long, value_name = "DIR")]
    into: Option<PathBuf>,
    /// Method of identification, instead of the study's own.
    #[arg(long, value_enum)]
    method: Option<MethodChoice>,
    #[command(flatten)]
    permission: Permission,
}

/// Identifies the study with its external solver and records the solver's runs.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let mut loaded = study(&arguments.study, shell)?;
    if let Some(method) = arguments.method {
        loaded.study.identify.method = method.into();
    }
    // The study's own choice of backend is overridden, because a run of the built-in solver leaves nothing to record.
    loaded.study.solver.backend = BackendChoice::Command;
    let program = NamedProgram::of_study(&loaded.study);
    arguments.permission.ask(program.as_ref(), shell)?;
    let mut backend = solver::command(&loaded.study, None, &|note| {
        shell.complain(std::slice::from_ref(note));
    });
    let recording = match &arguments.into {
        Some(folder) => Recording::new(folder),
        None => solver::recording(&loaded.study),
    };
    backend.record = Some(recording.clone());
    interrupt::listen();
    let bar = Progress::new("identifying", shell, || None);
    let outcome = fitted(&loaded, &mut backend, &bar, true);
    drop(bar);
    let (runs, failed) = backend.tally();
    shell.print(&format!(
        "runs with a result, which were recorded: {} of {runs}\n`{}` now contains {}\n",
        runs - failed,
        recording.folder.display(),
        counted(recording.count(), "run")
    ));
    match outcome {
        Ok(fit) if fit.converged => Ok(Exit::Fine),
        Ok(_) => Ok(Exit::NoAnswer),
        Err(error) => {
            shell.fail(Diagnostic::error(Code::NoFit, error.to_string()));
            Err(Exit::NoAnswer)
        }
    }
}
