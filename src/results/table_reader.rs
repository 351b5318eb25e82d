use std::sync::Arc;

use admire_syntax::diagnostic::Diagnostic;

use super::blocks::Blocks;
use super::{Catalogue, Header, ResultsError, ResultsReader, ResultsTable, Step, Values};

/// Step-by-step reader of a table in memory. The steps get the block names that they would have in an XRF file.
#[derive(Debug)]
pub(super) struct TableReader {
    file: Arc<str>,
    table: ResultsTable,
    next: usize,
    blocks: Blocks,
}

impl TableReader {
    /// Creates a reader that begins at the first step. `file` is the name used in messages.
    pub(super) fn new(file: impl Into<Arc<str>>, table: ResultsTable) -> Self {
        Self {
            file: file.into(),
            table,
            next: 0,
            blocks: Blocks::default(),
        }
    }
}

impl ResultsReader for TableReader {
    fn header(&self) -> &Header {
        &self.table.header
    }

    fn catalogue(&self) -> &Catalogue {
        &self.table.catalogue
    }

    fn next_step(&mut self) -> Result<Option<Step<'_>>, ResultsError> {
        let Some(&kind) = self.table.kinds.get(self.next) else {
            return Ok(None);
        };
        self.blocks.take(kind);
        let index = self.next;
        self.next += 1;
        let width = self.table.catalogue.len();
        Ok(Some(Step {
            file: &self.file,
            index,
            kind,
            block: self.blocks.name(),
            values: Values::Numbers(&self.table.values[index * width..(index + 1) * width]),
        }))
    }

    fn diagnostics(&self) -> &[Diagnostic] {
        &[]
    }
}
