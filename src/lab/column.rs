//! Entries of a mapping: what one column of a laboratory's table holds.

use super::characteristic::Target;
use admire_kc::Side;
use admire_syntax::text::Span;

/// What one column holds, in the words of the laboratory. What is not stated is `None`.
#[derive(Clone, Default, PartialEq, Debug)]
pub struct Column {
    /// Name of the column, with or without its unit.
    pub name: String,
    /// What the column holds.
    pub is: Option<Target>,
    /// Name of the load case column that takes the values, besides or instead of [`Self::is`].
    pub load: Option<String>,
    /// Factor to the sign of the load in the deck: 1 or -1.
    pub load_sign: Option<f64>,
    /// Side of the wheel.
    pub side: Option<Side>,
    /// Unit, if the heading does not state it.
    pub unit: Option<String>,
    /// Direction in which values count positive.
    pub positive: Option<String>,
    /// Length over which an angle is measured as a length, in mm, such as the diameter of the rim.
    pub over_mm: Option<f64>,
    /// Place of the entry in the file of the mapping; `None` for a proposal.
    pub span: Option<Span>,
}
