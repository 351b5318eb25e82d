use super::BackendError;
use admire_solver::model::Model;
use admire_solver::statics::StaticSettings;
use admire_solver::system::{Slot, System};
use admire_syntax::Address;
use admire_syntax::diagnostic::Severity;

/// Compiles a model for the built-in solver.
///
/// # Errors
/// Returns [`BackendError::NotSolvable`] if the model contains elements that the built-in solver does not support and that would change the
/// results.
pub fn compile(model: &Model) -> Result<System, BackendError> {
    let checked = System::compile(model);
    let errors: Vec<_> = checked
        .diagnostics
        .iter()
        .filter(|diagnostic| diagnostic.severity == Severity::Error)
        .cloned()
        .collect();
    if errors.is_empty() {
        Ok(checked.value)
    } else {
        Err(BackendError::NotSolvable(errors))
    }
}

/// Returns the settings in the EQUILIBRIUM statement of the deck with tighter tolerances, because parameter estimation needs more accurate
/// solutions than a display.
pub fn tight_settings(system: &System) -> StaticSettings {
    let deck = StaticSettings::from(system.settings());
    let tight = StaticSettings::tight();
    StaticSettings {
        error: deck.error.min(tight.error),
        imbalance: deck.imbalance.min(tight.imbalance),
        maxit: deck.maxit.max(tight.maxit),
        budget: None,
        ..deck
    }
}

/// Returns the parameter slot of an address.
///
/// # Errors
/// Returns [`BackendError::UnknownTarget`] if the solver cannot change the value at the address.
pub fn slot(system: &System, address: &Address) -> Result<Slot, BackendError> {
    system
        .catalogue()
        .slot(address)
        .ok_or_else(|| BackendError::UnknownTarget(address.clone()))
}
