use admire_solver::model::Model;
use admire_solver::statics::{Balance, SolveError};
use admire_solver::system::Equilibrium;
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::{Address, Dataset};

use super::LoadProgramme;

/// Request to solve all load cases of a deck.
#[derive(Clone, Copy, Debug)]
pub struct SweepRequest<'a> {
    /// The deck as written by the user.
    pub dataset: &'a Dataset,
    /// The model made from the deck. Poses are returned in the order of its parts.
    pub model: &'a Model,
    /// Parameter values that differ from the deck, with their addresses; angles in radians.
    pub theta: &'a [(Address, f64)],
    /// Loads and load cases; the cases are applied in this order.
    pub programme: &'a LoadProgramme,
}

/// Reason why a load case has no solution.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum CaseFailure {
    /// The built-in solver found no equilibrium.
    #[error(transparent)]
    NoEquilibrium(#[from] SolveError),
    /// The external program wrote no output step for this load case.
    #[error("the solver wrote no equilibrium for this case{}", .message.as_ref().map_or_else(String::new, |m| format!(": {m}")))]
    NoStep {
        /// Message of the program about the load case, if there is one.
        message: Option<String>,
    },
}

/// Outcome of one load case: its equilibrium, or the reason why there is none.
pub(crate) type CaseOutcome = Result<Equilibrium, CaseFailure>;

/// Result of a request: one outcome for each load case of the programme.
#[derive(Clone, PartialEq, Debug)]
pub struct Sweep {
    /// Outcomes of the load cases, in the order of the programme.
    pub cases: Vec<CaseOutcome>,
}

impl Sweep {
    /// Returns the equilibrium of a load case, if the case was solved.
    pub fn equilibrium(&self, case: usize) -> Option<&Equilibrium> {
        self.cases
            .get(case)
            .and_then(|outcome| outcome.as_ref().ok())
    }
}

/// Reason why an external run gave no valid result.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum RunError {
    /// The deck cannot be edited as the request requires; the text is the reason.
    #[error("the deck cannot be prepared: {0}")]
    Deck(String),
    /// No program is available to make the run, and the run was not recorded.
    #[error("there is no recording of this run in `{folder}` (hash {key})")]
    NotRecorded {
        /// Hash of the input files of the run, which names its folder in a recording.
        key: String,
        /// Folder of the recorded runs.
        folder: String,
    },
    /// The files of the run cannot be written; the text is the reason.
    #[error("the files of the run cannot be written: {0}")]
    Files(String),
    /// The external program cannot be started.
    #[error("`{program}` cannot be started: {reason}")]
    Start {
        /// Name of the program.
        program: String,
        /// Error message of the operating system.
        reason: String,
    },
    /// The run took longer than its time limit and was killed.
    #[error("the run was killed after {seconds} s, its time limit\n{tail}")]
    Timeout {
        /// Time limit in seconds.
        seconds: f64,
        /// Last lines that the run printed.
        tail: String,
    },
    /// The run was killed because it produced too much output.
    #[error("the run was killed: it {what}\n{tail}")]
    Output {
        /// Description of what was too large.
        what: String,
        /// Last lines that the run printed.
        tail: String,
    },
    /// The external program got no licence.
    #[error("the solver got no licence{}: {line}", if *waited > 0.0 { format!(" within {waited} s") } else { String::new() })]
    Licence {
        /// Line of the output that reports the missing licence.
        line: String,
        /// Time in seconds spent on all attempts to get a licence, including the pauses.
        waited: f64,
    },
    /// The run failed or crashed.
    #[error("the run ended with {}\n{tail}", code.map_or_else(|| "a crash".to_string(), |code| format!("exit code {code}")))]
    Exit {
        /// Exit code; `None` if the run was killed by a signal.
        code: Option<i32>,
        /// Last lines that the run printed.
        tail: String,
    },
    /// The results file is missing, incomplete, from another run or model, or inconsistent.
    #[error("{reason}\n{tail}")]
    Results {
        /// Description of the fault.
        reason: String,
        /// Last lines that the run printed.
        tail: String,
    },
    /// The output steps cannot be matched with the load cases, and the messages do not show which cases failed.
    #[error("the results hold {steps} equilibria for {cases} load cases\n{tail}")]
    Steps {
        /// Number of static output steps in the results file.
        steps: usize,
        /// Number of requested load cases.
        cases: usize,
        /// Last lines that the run printed.
        tail: String,
    },
}

/// Reason why no load case of a request could be solved.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BackendError {
    /// The built-in solver does not support all elements of this model; the diagnostics name them.
    #[error("the built-in solver cannot solve this model: {}", .0.first().map_or("", |d| d.message.as_str()))]
    NotSolvable(Vec<Diagnostic>),
    /// An external run gave no valid result.
    #[error("{reason} (files kept in {})", folder.display())]
    Run {
        /// Reason of the failure.
        reason: Box<RunError>,
        /// Folder that contains the files of the run.
        folder: std::path::PathBuf,
        /// True if the program is given up: no run has given a result yet, or several consecutive runs had to be killed.
        dead: bool,
    },
    /// The requested run was not recorded.
    #[error(
        "no recorded run has this deck and these commands (hash {}, {recorded} {} in {}); a study that has changed since \
         needs a new recording by `admire record`",
        &key[..16],
        if *recorded == 1 { "run" } else { "runs" },
        folder.display()
    )]
    NotRecorded {
        /// SHA-256 of the input files of the run.
        key: String,
        /// Number of runs in the recording.
        recorded: usize,
        /// Folder of the recorded runs.
        folder: std::path::PathBuf,
    },
    /// The solver cannot change the value at this address between runs.
    #[error("{0} is not the address of a number or function of the model")]
    UnknownTarget(Address),
}

impl BackendError {
    /// Returns true if a request with other parameter values would fail too.
    ///
    /// The reason may be an unsupported model, an unknown address, a missing program, licence or recording, files that cannot be written,
    /// or a program that was given up.
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

/// A solver for load cases.
pub trait Backend {
    /// Returns the name of the backend: `native`, `command` or `replay`.
    fn name(&self) -> &'static str;

    /// Solves every load case of the programme, in order. A case without an equilibrium does not end the sweep.
    ///
    /// # Errors
    /// Returns a [`BackendError`] if a common cause, such as a missing program, prevents the solution of all cases.
    fn sweep(&mut self, request: &SweepRequest<'_>) -> Result<Sweep, BackendError>;

    /// Solves several independent requests, possibly in parallel. Results are in the order of the requests.
    fn sweeps(&mut self, requests: &[SweepRequest<'_>]) -> Vec<Result<Sweep, BackendError>> {
        requests.iter().map(|request| self.sweep(request)).collect()
    }

    /// Returns the largest residual of the force balance of any part in all equilibria so far; `None` if the backend does not compute it.
    fn balance(&self) -> Option<&Balance> {
        None
    }

    /// Returns remarks for the user about the runs made so far.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }
}
