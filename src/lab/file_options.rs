//! Options for reading the text of a file: section `[file]` of a mapping.

use admire_kc::{Side, TestKind};

/// Options for reading a file. The default of each option is determined from the file itself.
#[derive(Clone, Default, PartialEq, Eq, Debug)]
pub struct FileOptions {
    /// Name of the only sheet of a workbook to read; all sheets if absent.
    pub sheet: Option<String>,
    /// Numbers of the heading lines, counted from 1. Two lines are joined to one heading for each column.
    pub header: Vec<usize>,
    /// Number of the line with the units, counted from 1.
    pub units: Option<usize>,
    /// Separator of the cells.
    pub delimiter: Option<u8>,
    /// Decimal mark: a point or a comma.
    pub decimal: Option<u8>,
    /// Test of all rows that no column, title or sheet assigns to a test.
    pub test: Option<TestKind>,
    /// Side of all columns for which no side is stated.
    pub side: Option<Side>,
    /// Interval of imported rows, from the first row of each test. All rows are imported if the interval is 0 or 1.
    pub every: usize,
}
