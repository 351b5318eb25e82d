use super::Name;
use crate::element::Degenerate;

/// Error: an element is undefined in the present configuration.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("{element}: {reason}")]
pub struct NoValue {
    /// Name of the element.
    pub element: Name,
    /// Reason of the failure.
    pub reason: NoValueReason,
}

/// Reason why an element is undefined.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum NoValueReason {
    /// The force law is undefined at this relative motion.
    #[error(transparent)]
    Degenerate(#[from] Degenerate),
    /// A function of the element has no value.
    #[error(transparent)]
    Function(#[from] crate::function::EvalError),
}
