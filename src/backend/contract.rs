use crate::diagnostic::Diagnostic;
use crate::model::Model;
use crate::statics::SolveError;
use crate::syntax::{Address, Dataset};
use crate::system::Equilibrium;

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
pub type CaseOutcome = Result<Equilibrium, CaseFailure>;

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

/// Why there is no answer at all.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BackendError {
    /// The built-in solver cannot solve this model as it is.
    #[error("the built-in solver cannot solve this model: {}", .0.first().map_or("", |d| d.message.as_str()))]
    NotSolvable(Vec<Diagnostic>),
    /// An address that names nothing which can be changed between runs.
    #[error("{0} names no number or function of the model")]
    UnknownTarget(Address),
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
}
