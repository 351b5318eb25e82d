//! Changes of files, in the terms of Adams/Car.

use serde::Serialize;

/// One changed value, in the terms of Adams/Car.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct WordChange {
    /// Object of the model, such as `hpl_lca_outer` or `bushing lca_front`.
    pub element: String,
    /// Sides of the entry: `left/right`, `left`, `right` or `single`.
    pub symmetry: &'static str,
    /// Name of the factor as in Adams/Insight: `x`, `fx_scaling_factor`, `t_preload_x`, `property_file`.
    pub factor: String,
    /// Value before the change, as a number or as a text. A missing scale factor counts as 1, a missing preload as 0.
    pub before: String,
    /// Value after the change.
    pub after: String,
    /// Unit of a number; empty for texts and ratios.
    pub unit: String,
    /// Standard error of the new value in its unit, if known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std_error: Option<f64>,
    /// Origin of the change.
    pub because: String,
}

/// New property file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct LearnedFile {
    /// Name of the file.
    pub name: String,
    /// Text of the file.
    pub text: String,
}

/// Result that a subsystem file cannot express, with the reason.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct NotWritten {
    /// Address in the deck, or name of the element.
    pub what: String,
    /// Reason, as a phrase.
    pub why: String,
}
