//! How the text of a file is read: the section `[file]` of a mapping.

use admire_kc::{Side, TestKind};

/// Options for reading a file. All have defaults that are found in the file itself.
#[derive(Clone, Default, PartialEq, Eq, Debug)]
pub struct FileOptions {
    /// Name of the only sheet of a workbook to read; all sheets if absent.
    pub sheet: Option<String>,
    /// Numbers of the lines with the headings, counted from 1. Two lines are joined to one heading for each column.
    pub header: Vec<usize>,
    /// Number of the line with the units, counted from 1.
    pub units: Option<usize>,
    /// Character between the cells.
    pub delimiter: Option<u8>,
    /// Decimal mark: a point or a comma.
    pub decimal: Option<u8>,
    /// Test of all rows that no column, title or sheet assigns to a test.
    pub test: Option<TestKind>,
    /// Side of all columns for which no side is stated.
    pub side: Option<Side>,
    /// Only each row of this number is imported, beginning with the first of each test; all if 0 or 1.
    pub every: usize,
}
