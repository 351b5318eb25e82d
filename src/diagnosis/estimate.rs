//! Estimate of a parameter of a fitted effect.

/// Estimate of a parameter and its standard error, in the units of `diagnosis.json`.
#[derive(Clone, PartialEq, Debug)]
pub struct Estimate {
    /// Name of the parameter.
    pub name: String,
    /// Estimated value.
    pub value: f64,
    /// Standard error of the value.
    pub std_error: f64,
}
