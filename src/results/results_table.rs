use std::io;

use super::{Catalogue, Header, NumberStyle, StepKind};

/// The results of a run in memory: what an XRF file holds, a row of values for each step.
#[derive(Clone, PartialEq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct ResultsTable {
    /// What the file would say of itself.
    pub header: Header,
    /// Names of the columns; the component with id k is value k - 1 of each row.
    pub catalogue: Catalogue,
    /// How numbers are spelled when the table is written.
    pub numbers: NumberStyle,
    /// Status of the run: `Successful` or `Failed`; empty while it goes on.
    pub status: String,
    /// Kind of each step.
    pub kinds: Vec<StepKind>,
    /// All values, step by step. Not among what is serialised: JSON would take several times their room.
    #[serde(skip)]
    pub values: Vec<f64>,
}

impl ResultsTable {
    /// A table without steps.
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

    /// Adds a step.
    ///
    /// # Errors
    /// `InvalidInput` when there is not a value for each column or one is not finite: a table holds what a file can.
    pub(crate) fn push(&mut self, kind: StepKind, values: &[f64]) -> io::Result<()> {
        let columns = self.catalogue.len();
        if values.len() != columns {
            let message = format!("{} values for {columns} columns", values.len());
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
