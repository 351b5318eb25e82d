use std::io::{self, Write};

use super::{Catalogue, Header, NumberStyle, StepKind, Style, XrfWriter};

/// The results of a run in memory: what an XRF file holds, a row of values for each step.
#[derive(Clone, PartialEq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct ResultsTable {
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
    pub(crate) fn new(header: Header, catalogue: Catalogue, numbers: NumberStyle) -> Self {
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
    /// `InvalidInput` when a value is not finite, as [`XrfWriter::step`] has it: a table is what a file can hold.
    pub(crate) fn push(&mut self, kind: StepKind, values: &[f64]) -> io::Result<()> {
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let message = format!("the value of column {} is not finite", at + 1);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        self.kinds.push(kind);
        self.values.extend_from_slice(values);
        Ok(())
    }

    /// The same under another header.
    ///
    /// # Errors
    /// When the output cannot be written.
    pub(crate) fn write_as(&self, header: &Header, output: impl Write) -> io::Result<()> {
        let style = Style {
            numbers: self.numbers,
            ..Style::default()
        };
        let mut writer = XrfWriter::create(output, header, &self.catalogue, style)?;
        let width = self.catalogue.len().max(1);
        for (kind, values) in self.kinds.iter().zip(self.values.chunks(width)) {
            writer.step(*kind, values)?;
        }
        writer.finish(&self.status)?;
        Ok(())
    }
}
