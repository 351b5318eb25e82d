use admire_kc::BenchError;
use admire_syntax::diagnostic::{Diagnostic, Severity};

/// A test or load case without an equilibrium.
#[derive(Clone, Debug)]
pub struct TuneError {
    /// Values of the unknowns as the user states them; empty for the deck of the study.
    pub unknowns: Vec<f64>,
    /// Reason why there is no result.
    pub why: BenchError,
}

/// Returns true if there is an error among diagnostics.
pub(crate) fn has_errors(diagnostics: &[Diagnostic]) -> bool {
    let error = |diagnostic: &Diagnostic| diagnostic.severity == Severity::Error;
    diagnostics.iter().any(error)
}
