/// Why a function has no value.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Fault {
    /// The arguments lie outside of where the function is defined.
    NotDefined,
    /// The value is too large for a double.
    TooLarge,
    /// The two ends of a step or sweep are equal.
    EqualEnds,
}

/// A function without a value at the present state. Its text, address and state are known to the caller.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{function} {}", match fault {
    Fault::NotDefined => "is not defined for its arguments",
    Fault::TooLarge => "is too large to be a number",
    Fault::EqualEnds => "has x0 equal to x1",
})]
pub struct EvalError {
    /// The function or operator, as written in expressions.
    pub function: &'static str,
    /// What is wrong.
    pub fault: Fault,
}
