use admire_solver::model::Model;
use admire_solver::statics::{Balance, SolveError};
use admire_solver::system::Equilibrium;
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::{Address, Dataset};

use super::LoadProgramme;

/// Request to solve load cases.
#[derive(Clone, Copy, Debug)]
pub struct SweepRequest<'a> {
    /// The user's own file.
    pub dataset: &'a Dataset,
    /// The lowered dataset. Part poses are returned in the order of its parts.
    pub model: &'a Model,
    /// Numbers that differ from the file, by address; angles in radians.
    pub theta: &'a [(Address, f64)],
    /// Load cases, applied in this order.
    pub programme: &'a LoadProgramme,
}

/// Reason why a case has no solution.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum CaseFailure {
    /// The built-in solver found no equilibrium.
    #[error(transparent)]
    NoEquilibrium(#[from] SolveError),
    /// The external program wrote no step for this case.
    #[error("the solver wrote no equilibrium for this case{}", .message.as_ref().map_or_else(String::new, |m| format!(": {m}")))]
    NoStep {
        /// Message of the program about the case.
        message: Option<String>,
    },
}

/// Result of one case: its equilibrium, or the reason why there is none.
pub(crate) type CaseOutcome = Result<Equilibrium, CaseFailure>;

/// Answer to a request: one outcome per case of the programme.
#[derive(Clone, PartialEq, Debug)]
pub struct Sweep {
    /// Outcomes in the order of the programme.
    pub cases: Vec<CaseOutcome>,
}

impl Sweep {
    /// Returns the equilibrium of a case, if it was solved.
    pub fn equilibrium(&self, case: usize) -> Option<&Equilibrium> {
        self.cases
            .get(case)
            .and_then(|outcome| outcome.as_ref().ok())
    }
}

/// Reason why an external run gave no answer.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum RunError {
    /// The deck cannot be edited as requested.
    #[error("the deck cannot be prepared: {0}")]
    Deck(String),
    /// There is no program to start, and no recording of this run.
    #[error("there is no recording of this run in `{folder}`: {key}")]
    NotRecorded {
        /// Content key of the run, after which its folder would be named.
        key: String,
        /// Folder of the recordings.
        folder: String,
    },
    /// Files of the run cannot be written.
    #[error("the files of the run cannot be written: {0}")]
    Files(String),
    /// The program cannot be started.
    #[error("`{program}` cannot be started: {reason}")]
    Start {
        /// Name of the program.
        program: String,
        /// Error message of the system.
        reason: String,
    },
    /// The run exceeded its time limit and was killed.
    #[error("the run was killed after {seconds} s\n{tail}")]
    Timeout {
        /// Time limit in seconds.
        seconds: f64,
        /// Last lines of its log.
        tail: String,
    },
    /// The run was killed because it produced too much output.
    #[error("the run was killed: it {what}\n{tail}")]
    Output {
        /// Description of the excess.
        what: String,
        /// Last lines of its log.
        tail: String,
    },
    /// The solver got no licence.
    #[error("the solver got no licence{}: {line}", if *waited > 0.0 { format!(" within {waited} s") } else { String::new() })]
    Licence {
        /// Line of the log that reports it.
        line: String,
        /// Seconds waited for a licence.
        waited: f64,
    },
    /// The run failed or crashed.
    #[error("the run ended with {}\n{tail}", code.map_or_else(|| "a crash".to_string(), |code| format!("exit code {code}")))]
    Exit {
        /// Exit code, if the run was not killed by a signal.
        code: Option<i32>,
        /// Last lines of its log.
        tail: String,
    },
    /// The results file is missing, incomplete, from another run, or inconsistent.
    #[error("{reason}\n{tail}")]
    Results {
        /// Description of the fault.
        reason: String,
        /// Last lines of the log.
        tail: String,
    },
    /// Steps and load cases do not match, and the messages do not identify the failed cases.
    #[error("the results hold {steps} equilibria for {cases} load cases\n{tail}")]
    Steps {
        /// Number of static steps in the results.
        steps: usize,
        /// Number of requested load cases.
        cases: usize,
        /// Last lines of the log.
        tail: String,
    },
}

/// Reason why a sweep has no answer at all.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BackendError {
    /// The built-in solver cannot solve this model as it is.
    #[error("the built-in solver cannot solve this model: {}", .0.first().map_or("", |d| d.message.as_str()))]
    NotSolvable(Vec<Diagnostic>),
    /// An external run gave no valid answer.
    #[error("{reason} (files kept in {})", folder.display())]
    Run {
        /// Reason of the failure.
        reason: Box<RunError>,
        /// Folder with the files of the run.
        folder: std::path::PathBuf,
        /// True if no run of this program has given an answer yet, or several runs in a row were killed.
        dead: bool,
    },
    /// This run was not recorded.
    #[error(
        "no recorded run has this deck and these commands (content {}, {recorded} runs in {}); `admire record` makes recordings, \
         and a study that was changed since needs a new one",
        &key[..16],
        folder.display()
    )]
    NotRecorded {
        /// SHA-256 of the input files of the run.
        key: String,
        /// Number of recorded runs.
        recorded: usize,
        /// Folder of the recordings.
        folder: std::path::PathBuf,
    },
    /// The address names nothing that can be changed between runs.
    #[error("{0} names no number or function of the model")]
    UnknownTarget(Address),
}

impl BackendError {
    /// Returns true if other parameter values would not help: unsolvable model, missing program, licence, disk space or recording, or dead
    /// program.
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

/// A solver of load cases.
pub trait Backend {
    /// Returns the name of the backend: `native`, `command` or `replay`.
    fn name(&self) -> &'static str;

    /// Solves every case of the programme in order. A case without an equilibrium does not end the sweep.
    ///
    /// # Errors
    /// [`BackendError`] when no case could be solved.
    fn sweep(&mut self, request: &SweepRequest<'_>) -> Result<Sweep, BackendError>;

    /// Solves several independent requests, possibly in parallel. Answers are in the order of the requests.
    fn sweeps(&mut self, requests: &[SweepRequest<'_>]) -> Vec<Result<Sweep, BackendError>> {
        requests.iter().map(|request| self.sweep(request)).collect()
    }

    /// Returns the largest residual of the force balance on a part in all equilibria so far; `None` if the backend cannot compute it.
    fn balance(&self) -> Option<&Balance> {
        None
    }

    /// Returns remarks for the user about the runs so far.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }
}
