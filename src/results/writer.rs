use std::io;

use super::{ResultsTable, StepKind};

/// Where the steps of a run go: a file or a table in memory.
pub trait ResultsWriter {
    /// Adds a step: a value for each column.
    ///
    /// # Errors
    /// `InvalidInput` when the number of values is not that of the columns or a value is not finite; otherwise when the output cannot be
    /// written.
    fn step(&mut self, kind: StepKind, values: &[f64]) -> io::Result<()>;

    /// Ends the results with the status of the run (`Successful`) and gives them back where they are kept in memory.
    ///
    /// # Errors
    /// When the output cannot be written.
    fn finish(self: Box<Self>, status: &str) -> io::Result<Option<ResultsTable>>;
}

impl ResultsWriter for ResultsTable {
    fn step(&mut self, kind: StepKind, values: &[f64]) -> io::Result<()> {
        self.push(kind, values)
    }

    fn finish(mut self: Box<Self>, status: &str) -> io::Result<Option<ResultsTable>> {
        self.status = status.to_string();
        Ok(Some(*self))
    }
}
