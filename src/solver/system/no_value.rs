use super::Name;
use crate::element::Degenerate;

/// An element that has no value in this configuration.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("{element}: {reason}")]
pub struct NoValue {
    /// Which element.
    pub element: Name,
    /// Why.
    pub reason: Reason,
}

/// Why an element has no value.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum Reason {
    /// The motion is one at which the law has no value.
    #[error(transparent)]
    Degenerate(#[from] Degenerate),
    /// Its function has no value.
    #[error(transparent)]
    Function(#[from] crate::function::EvalError),
}
