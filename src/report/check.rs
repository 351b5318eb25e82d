//! One line of the plausibility table.

/// Assessment of a line.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Verdict {
    /// Within the usual range.
    Plausible,
    /// Unusual; a person should check it.
    Doubtful,
    /// Certainly a mistake; a fit of this study would be meaningless.
    Impossible,
}

/// One line of the plausibility table.
#[derive(Clone, PartialEq, Debug)]
pub struct Check {
    /// Checked property.
    pub what: &'static str,
    /// Value found, with its unit.
    pub found: String,
    /// Assessment.
    pub verdict: Verdict,
    /// Reason, empty if plausible.
    pub why: String,
}
