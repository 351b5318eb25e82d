//! Entries of a mapping. Each describes the content of one column of a laboratory's table.

use super::characteristic::Target;
use admire_kc::Side;
use admire_syntax::text::Span;

/// Content of one column, in the words of the laboratory. A field is `None` if it is not stated.
#[derive(Clone, Default, PartialEq, Debug)]
pub struct Column {
    /// Name of the column, with or without its unit.
    pub name: String,
    /// Content of the column.
    pub is: Option<Target>,
    /// Name of the load case column that receives the values, in addition to [`Self::is`] or instead of it.
    pub load: Option<String>,
    /// Factor to the sign of the load in the deck: 1 or -1.
    pub load_sign: Option<f64>,
    /// Side of the wheel.
    pub side: Option<Side>,
    /// Unit, if the heading does not state it.
    pub unit: Option<String>,
    /// Positive direction of the values.
    pub positive: Option<String>,
    /// Length in mm over which an angle is measured as a displacement, such as the diameter of the rim.
    pub over_mm: Option<f64>,
    /// Place of the entry in the file of the mapping; `None` for a proposal.
    pub span: Option<Span>,
}
