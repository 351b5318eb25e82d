use admire_kc::BenchError;
use admire_syntax::diagnostic::{Diagnostic, Severity};

/// Error: a test or load case has no equilibrium.
#[derive(Clone, Debug)]
pub struct TuneError {
    /// Values of the unknowns, in the form in which the user states them; empty for the deck of the study.
    pub unknowns: Vec<f64>,
    /// Reason why there is no result.
    pub why: BenchError,
}

/// Returns true if the diagnostics include an error.
pub(crate) fn has_errors(diagnostics: &[Diagnostic]) -> bool {
    let error = |diagnostic: &Diagnostic| diagnostic.severity == Severity::Error;
    diagnostics.iter().any(error)
}
