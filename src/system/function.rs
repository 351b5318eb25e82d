use super::structure::Name;

/// A FUNCTION of the model, ready to evaluate.
#[derive(Debug)]
pub(crate) struct CompiledFunction {
    /// The statement it belongs to.
    pub owner: Name,
    /// First slot of its literals.
    pub literals: usize,
    /// Slot of the constant that replaces it; NaN there means that the function itself is in force.
    pub replacement: usize,
    /// Sign of the only literal.
    pub sign: f64,
}
