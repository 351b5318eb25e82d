use std::io;

use super::{Catalogue, Header, NumberStyle, StepKind};

/// Results of a run in memory: the content of an XRF file, with one row of values for each output step.
#[derive(Clone, PartialEq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct ResultsTable {
    /// Header that the table gets when it is written as an XRF file.
    pub header: Header,
    /// Names of the columns; the value of the column with id k is at index k - 1 of each row.
    pub catalogue: Catalogue,
    /// Format that numbers get when the table is written as an XRF file.
    pub numbers: NumberStyle,
    /// Status of the run: `Successful` or `Failed`; empty while the run is in progress.
    pub status: String,
    /// Kind of each output step.
    pub kinds: Vec<StepKind>,
    /// All values, one output step after the other. They are not serialised, because JSON would take several times their memory.
    #[serde(skip)]
    pub values: Vec<f64>,
}

impl ResultsTable {
    /// Creates a table without output steps.
    pub fn new(header: Header, catalogue: Catalogue, numbers: NumberStyle) -> Self {
        Self {
            header,
            catalogue,
            numbers,
            status: String::new(),
            kinds: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Appends an output step.
    ///
    /// # Errors
    /// Returns `InvalidInput` if the number of values differs from the number of columns, or if a value is not finite. A table thus
    /// contains only values that can be written to a file.
    pub(crate) fn push(&mut self, kind: StepKind, values: &[f64]) -> io::Result<()> {
        let columns = self.catalogue.len();
        if values.len() != columns {
            let message = format!(
                "the step has {} values, but the file has {columns} columns",
                values.len()
            );
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let message = format!("the value of column {} is not finite", at + 1);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        self.kinds.push(kind);
        self.values.extend_from_slice(values);
        Ok(())
    }
}
