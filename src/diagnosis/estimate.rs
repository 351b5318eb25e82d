//! Fitted parameter of an effect.

/// Estimate of a parameter and its standard error, in the units of `diagnosis.json`.
#[derive(Clone, PartialEq, Debug)]
pub struct Estimate {
    /// Name of the parameter.
    pub name: String,
    /// Estimate.
    pub value: f64,
    /// Standard error.
    pub std_error: f64,
}
