/// Reason why a function has no value.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Fault {
    /// The arguments lie outside the domain of the function.
    NotDefined,
    /// The value exceeds the range of a double.
    TooLarge,
    /// The two ends of a step or sweep are equal.
    EqualEnds,
}

/// Error: a function has no value at the present state. The caller adds the expression text, its location in the deck and the state.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{function} {}", match fault {
    Fault::NotDefined => "is not defined for its arguments",
    Fault::TooLarge => "exceeds the range of floating-point numbers",
    Fault::EqualEnds => "has x0 equal to x1",
})]
pub struct EvalError {
    /// Name of the function or operator, as written in expressions.
    pub function: &'static str,
    /// Reason of the failure.
    pub fault: Fault,
}
