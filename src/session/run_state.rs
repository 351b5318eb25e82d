use std::io::Write;
use std::path::{Path, PathBuf};

use admire_solver::model::Ignore;
use admire_solver::statics::Balance;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::text::{Source, Span};
use admire_syntax::{Dataset, Statement};

use super::ending::{Ending, Stop};
use super::file_policy::FilePolicy;
use super::loaded::Loaded;
use super::located::Sources;
use super::message::Messages;
use super::moment::Watcher;
use super::record::Record;
use super::saved::SavedStates;

/// A run: executes commands on a model and writes the output files that ADAMS would write.
pub struct Session<'a> {
    pub(super) messages: Messages<'a>,
    pub(super) sources: Sources,
    pub(super) directory: PathBuf,
    /// Folders in which files are looked up: the working directory, then the folders of the command files.
    pub(super) folders: Vec<PathBuf>,
    pub(super) policy: FilePolicy,
    pub(super) loaded: Option<Loaded>,
    pub(super) kept: SavedStates,
    pub(super) stop_on_failure: bool,
    /// Statements that the user allows to be left out of models.
    pub(super) ignored: Vec<Ignore>,
    /// Error about the first file that could not be written; the last line of the messages repeats it.
    pub(super) unwritten: Option<String>,
    pub(super) ending: Ending,
    /// Stem of the name of the message file, if the run reads no model.
    pub(super) stem: Option<String>,
    pub(super) watcher: Option<Watcher<'a>>,
    /// Dataset that replaces every dataset named in commands. The outputs then stay in memory.
    pub(super) given: Option<&'a Checked<Dataset>>,
    /// Outputs of the last model that were kept in memory.
    pub(super) record: Option<Record>,
    /// Largest residual of the force balance in all equilibria found so far.
    pub(super) worst_balance: Balance,
}

/// Result of executing a command; an error ends the run.
pub(super) type Flow = Result<(), Stop>;

impl<'a> Session<'a> {
    /// Creates a session in a working directory; an empty path means the working directory of the process. Messages are also written to
    /// `console`.
    pub fn new(console: Box<dyn Write + 'a>, directory: &Path) -> Self {
        Self {
            messages: Messages::new(console, directory),
            sources: Sources::default(),
            directory: directory.to_path_buf(),
            folders: vec![directory.to_path_buf()],
            policy: FilePolicy::new(directory),
            loaded: None,
            kept: SavedStates::default(),
            stop_on_failure: false,
            ignored: Vec::new(),
            unwritten: None,
            ending: Ending {
                stop: Stop::Finished,
                misunderstood: 0,
                refused: 0,
                failed: 0,
                results: None,
            },
            stem: None,
            watcher: None,
            given: None,
            record: None,
            worst_balance: Balance::default(),
        }
    }

    /// Restricts reading to the folders in which files may be written. The folders `more` are added to these.
    #[must_use]
    pub fn confined(mut self, more: &[PathBuf]) -> Self {
        for folder in more {
            self.policy.allow(folder);
        }
        self.policy.confine();
        self
    }

    /// Allows the given statements to be left out of models if the solver does not support them. A warning is reported for each statement
    /// left out.
    #[must_use]
    pub fn ignoring(mut self, ignored: Vec<Ignore>) -> Self {
        self.ignored = ignored;
        self
    }

    /// Sets the stem of the message file for runs that read no model. Programs that wait for the last lines of this file then find it.
    #[must_use]
    pub(crate) fn named(mut self, stem: &str) -> Self {
        self.stem = Some(stem.to_string());
        self
    }

    /// Reports a diagnostic in the messages of the run.
    pub(crate) fn complain(&mut self, diagnostic: &Diagnostic) {
        self.messages.diagnostic(diagnostic, &self.sources);
    }

    pub(super) fn no_model(&mut self, command: &Statement, source: &Source) -> Flow {
        let place = Some(Place {
            source,
            span: command.keyword,
        });
        self.misunderstood(
            Diagnostic::error(Code::NoModel, "no model was read before this command")
                .help("FILE/MODEL=name reads one"),
            place,
        )
    }

    /// Reports a command that is wrong and is not executed. The run continues.
    #[allow(clippy::unnecessary_wraps)] // Every command ends in a Flow.
    pub(super) fn misunderstood(
        &mut self,
        diagnostic: Diagnostic,
        place: Option<Place<'_>>,
    ) -> Flow {
        self.complain(&place.label(diagnostic));
        self.ending.misunderstood += 1;
        Ok(())
    }

    /// Reports a command that this solver does not execute. The run continues, but its results are not marked successful.
    #[allow(clippy::unnecessary_wraps)] // Every command ends in a Flow.
    pub(super) fn refused(&mut self, diagnostic: Diagnostic, place: Option<Place<'_>>) -> Flow {
        self.complain(&place.label(diagnostic));
        self.ending.refused += 1;
        if let Some(loaded) = &mut self.loaded {
            loaded.outputs.failed = true;
        }
        Ok(())
    }

    /// Counts a failed simulation, and ends the run if PREFERENCES/SIMFAIL=STOPCF requires it.
    pub(super) fn simulation_failed(&mut self) -> Flow {
        self.ending.failed += 1;
        if let Some(loaded) = &mut self.loaded {
            loaded.outputs.failed = true;
        }
        if self.stop_on_failure {
            self.messages.frame(
                "ERROR",
                "The simulation failed and PREFERENCES/SIMFAIL=STOPCF stops the command file.",
            );
            return Err(Stop::Simulation);
        }
        Ok(())
    }

    /// Reports that an output file cannot be written, and ends the run.
    pub(super) fn unwritable(&mut self, diagnostic: &Diagnostic) -> Flow {
        self.complain(diagnostic);
        self.unwritten.get_or_insert(diagnostic.message.clone());
        Err(Stop::File)
    }
}

/// Location in a command file to which diagnostics refer.
#[derive(Clone, Copy)]
pub(super) struct Place<'s> {
    pub source: &'s Source,
    pub span: Span,
}

/// Adds a location to diagnostics that have none.
pub(super) trait Locate {
    fn label(&self, diagnostic: Diagnostic) -> Diagnostic;
}

impl Locate for Option<Place<'_>> {
    fn label(&self, diagnostic: Diagnostic) -> Diagnostic {
        match self {
            Some(place) if diagnostic.labels.is_empty() => {
                diagnostic.label(place.source.name(), place.span, "")
            }
            _ => diagnostic,
        }
    }
}
