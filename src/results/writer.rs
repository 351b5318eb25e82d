use std::io;

use super::{ResultsTable, StepKind};

/// Destination for the output steps of a run: a file or a table in memory.
pub trait ResultsWriter {
    /// Adds an output step with one value for each column.
    ///
    /// # Errors
    /// Returns `InvalidInput` if the number of values differs from the number of columns, or if a value is not finite. Returns another
    /// error if the output cannot be written.
    fn step(&mut self, kind: StepKind, values: &[f64]) -> io::Result<()>;

    /// Ends the results with the status of the run (such as `Successful`). Returns the table if the results are kept in memory.
    ///
    /// # Errors
    /// Returns an error if the output cannot be written.
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
