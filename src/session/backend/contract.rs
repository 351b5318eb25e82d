use admire_solver::model::Model;
use admire_solver::statics::{Balance, SolveError};
use admire_solver::system::Equilibrium;
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::{Address, Dataset};

use super::LoadProgramme;

/// What is to be solved.
#[derive(Clone, Copy, Debug)]
pub struct SweepRequest<'a> {
    /// The user's own file.
    pub dataset: &'a Dataset,
    /// The same, lowered: part poses come back in the order of its parts.
    pub model: &'a Model,
    /// Numbers that differ from the file, by address, angles in radians.
    pub theta: &'a [(Address, f64)],
    /// Load cases, applied in this order.
    pub programme: &'a LoadProgramme,
}

/// Why one case has no answer.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum CaseFailure {
    /// The built-in solver found no equilibrium.
    #[error(transparent)]
    NoEquilibrium(#[from] SolveError),
    /// The external program wrote no step for this case.
    #[error("the solver wrote no equilibrium for this case{}", .message.as_ref().map_or_else(String::new, |m| format!(": {m}")))]
    NoStep {
        /// What its message file says of it.
        message: Option<String>,
    },
}

/// One case: where the parts are, or why that is not known.
pub(crate) type CaseOutcome = Result<Equilibrium, CaseFailure>;

/// The answer to a request: one outcome per case of the programme.
#[derive(Clone, PartialEq, Debug)]
pub struct Sweep {
    /// In the order of the programme.
    pub cases: Vec<CaseOutcome>,
}

impl Sweep {
    /// The poses of a case, if it was solved.
    pub fn equilibrium(&self, case: usize) -> Option<&Equilibrium> {
        self.cases
            .get(case)
            .and_then(|outcome| outcome.as_ref().ok())
    }
}

/// Why an external run gave no answer.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum RunError {
    /// The deck cannot be edited as asked.
    #[error("the deck cannot be prepared: {0}")]
    Deck(String),
    /// There is no program, and no recording of this run.
    #[error("there is no recording of this run in `{folder}`: {key}")]
    NotRecorded {
        /// What its folder would be called.
        key: String,
        /// Where recordings are.
        folder: String,
    },
    /// Files of the run cannot be written.
    #[error("the files of the run cannot be written: {0}")]
    Files(String),
    /// The program cannot be started.
    #[error("`{program}` cannot be started: {reason}")]
    Start {
        /// The program.
        program: String,
        /// What the system says.
        reason: String,
    },
    /// It was killed.
    #[error("the run was killed after {seconds} s\n{tail}")]
    Timeout {
        /// Seconds it had.
        seconds: f64,
        /// The last lines of its log.
        tail: String,
    },
    /// It was killed because it wrote without end.
    #[error("the run was killed: it {what}\n{tail}")]
    Output {
        /// What it did.
        what: String,
        /// The last lines of its log.
        tail: String,
    },
    /// There was no licence.
    #[error("the solver got no licence{}: {line}", if *waited > 0.0 { format!(" within {waited} s") } else { String::new() })]
    Licence {
        /// How it said so.
        line: String,
        /// Seconds that were waited for one.
        waited: f64,
    },
    /// It failed or crashed.
    #[error("the run ended with {}\n{tail}", code.map_or_else(|| "a crash".to_string(), |code| format!("exit code {code}")))]
    Exit {
        /// Its exit code, if it was not killed by a signal.
        code: Option<i32>,
        /// The last lines of its log.
        tail: String,
    },
    /// The results file is missing, cut off, that of another run, or contradicts itself.
    #[error("{reason}\n{tail}")]
    Results {
        /// What is wrong with it.
        reason: String,
        /// The last lines of the log.
        tail: String,
    },
    /// Steps and load cases do not match, and the messages do not tell which cases failed.
    #[error("the results hold {steps} equilibria for {cases} load cases\n{tail}")]
    Steps {
        /// Static steps in the results.
        steps: usize,
        /// Load cases asked for.
        cases: usize,
        /// The last lines of the log.
        tail: String,
    },
}

/// Why there is no answer at all.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BackendError {
    /// The built-in solver cannot solve this model as it is.
    #[error("the built-in solver cannot solve this model: {}", .0.first().map_or("", |d| d.message.as_str()))]
    NotSolvable(Vec<Diagnostic>),
    /// An external run gave nothing that can be taken for an answer.
    #[error("{reason} (files kept in {})", folder.display())]
    Run {
        /// What went wrong.
        reason: Box<RunError>,
        /// Where its files are.
        folder: std::path::PathBuf,
        /// No run of this program gave an answer yet, or it was killed again and again.
        dead: bool,
    },
    /// Nobody recorded this run.
    #[error(
        "no recorded run has this deck and these commands (content {}, {recorded} runs in {}); `admire record` makes recordings, \
         and a study that was changed since needs a new one",
        &key[..16],
        folder.display()
    )]
    NotRecorded {
        /// SHA-256 of deck and command file.
        key: String,
        /// How many runs there are.
        recorded: usize,
        /// Where they are.
        folder: std::path::PathBuf,
    },
    /// An address that names nothing which can be changed between runs.
    #[error("{0} names no number or function of the model")]
    UnknownTarget(Address),
}

impl BackendError {
    /// True if no other numbers would help: there is no program, no licence, no disk, no recording, or the program is dead.
    pub fn is_lasting(&self) -> bool {
        match self {
            Self::NotSolvable(_) | Self::UnknownTarget(_) | Self::NotRecorded { .. } => true,
            Self::Run { reason, dead, .. } => {
                *dead
                    || matches!(
                        **reason,
                        RunError::Files(_) | RunError::Start { .. } | RunError::Licence { .. }
                    )
            }
        }
    }
}

/// Who solves.
pub trait Backend {
    /// Its name: `native`, `command`, `replay`.
    fn name(&self) -> &'static str;

    /// Solves every case of the programme, in its order. A case without an equilibrium does not end the sweep.
    ///
    /// # Errors
    /// [`BackendError`] when nothing could be solved.
    fn sweep(&mut self, request: &SweepRequest<'_>) -> Result<Sweep, BackendError>;

    /// Solves several requests that do not wait for each other; answers come in their order.
    fn sweeps(&mut self, requests: &[SweepRequest<'_>]) -> Vec<Result<Sweep, BackendError>> {
        requests.iter().map(|request| self.sweep(request)).collect()
    }

    /// What was left of the forces on a part at worst, in all equilibria so far; `None` if the backend does not know.
    fn balance(&self) -> Option<&Balance> {
        None
    }

    /// What a person should know of the runs so far.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }
}
