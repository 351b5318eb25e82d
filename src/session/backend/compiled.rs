use super::BackendError;
use admire_solver::model::Model;
use admire_solver::statics::StaticSettings;
use admire_solver::system::{Slot, System};
use admire_syntax::Address;
use admire_syntax::diagnostic::Severity;

/// Compiles a model for the built-in solver.
///
/// # Errors
/// [`BackendError::NotSolvable`] when the model has elements that are not solved and would change the answer.
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

/// Returns the settings of the deck's EQUILIBRIUM with tightened tolerances, because estimation needs more digits than a display.
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

/// Returns the slot of an address.
///
/// # Errors
/// [`BackendError::UnknownTarget`].
pub fn slot(system: &System, address: &Address) -> Result<Slot, BackendError> {
    system
        .catalogue()
        .slot(address)
        .ok_or_else(|| BackendError::UnknownTarget(address.clone()))
}
