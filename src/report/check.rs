//! Lines of the plausibility table.

/// Assessment of a property of the study.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Verdict {
    /// The property is in its usual range.
    Plausible,
    /// The property is unusual; a person should check it.
    Doubtful,
    /// The property is certainly a mistake; a fit of this study would be meaningless.
    Impossible,
}

/// One line of the plausibility table: a property of the study and its assessment.
#[derive(Clone, PartialEq, Debug)]
pub struct Check {
    /// Name of the property.
    pub what: &'static str,
    /// Value of the property, with its unit.
    pub found: String,
    /// Assessment of the property.
    pub verdict: Verdict,
    /// Reason for the assessment; empty if the property is plausible.
    pub why: String,
}
