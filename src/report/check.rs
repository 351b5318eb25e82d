//! A line of the table of plausibility.

/// What to think of a line.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Verdict {
    /// As such things are.
    Plausible,
    /// Unusual; a person should look.
    Doubtful,
    /// Cannot be meant: a fit of this would answer another question.
    Impossible,
}

/// One line of the table.
#[derive(Clone, PartialEq, Debug)]
pub struct Check {
    /// What was looked at.
    pub what: &'static str,
    /// What it is, with its unit.
    pub found: String,
    /// What to think of it.
    pub verdict: Verdict,
    /// Why, where it is not plausible.
    pub why: String,
}
