//! A number of an effect as a fit found it.

/// A number's estimate and its standard error in the units of `diagnosis.json`.
#[derive(Clone, PartialEq, Debug)]
pub struct Estimate {
    /// Its name.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Standard error.
    pub std_error: f64,
}
