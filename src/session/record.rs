//! Outputs of a run that are kept in memory instead of being written to files.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use admire_results::ResultsTable;
use admire_solver::motion::Mode;
use admire_solver::statics::Balance;
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::text::LineEnds;

use super::located::Sources;

/// Text that is still growing; its writer and the record share it.
type Text = Arc<Mutex<Vec<u8>>>;

/// Outputs of a run that writes no files.
#[derive(Debug, Default)]
pub struct Record {
    /// Results of the last model that has results, whether or not the model requests a results file.
    pub results: Option<ResultsTable>,
    /// Modes of the last LINEAR/EIGENSOL, with one mode of each conjugate pair, in the same order as in `.modes.json`.
    pub modes: Vec<Mode>,
    /// Largest residual of the recomputed force balance of any part, over all equilibria.
    pub balance: Balance,
    /// Content of the message file.
    pub messages: Vec<u8>,
    /// Warnings and errors, in the order in which they were reported.
    pub diagnostics: Vec<Diagnostic>,
    /// Files to which the diagnostics refer.
    pub sources: Sources,
    texts: BTreeMap<String, Text>,
}

impl Record {
    /// Returns a destination in memory for the output file with this extension.
    pub(super) fn sink(&mut self, extension: &str) -> Sink {
        let text = Text::default();
        self.texts.insert(extension.to_string(), text.clone());
        Sink::Memory(text)
    }

    /// Keeps the text of a complete file under the name of the file.
    pub(super) fn add(&mut self, path: &Path, text: &str) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let text = Arc::new(Mutex::new(text.as_bytes().to_vec()));
        self.texts.insert(name.into_owned(), text);
    }

    /// Returns the contents of all files except the results file and the message file. The keys are the extensions `req`, `gra` and `out`,
    /// and for files written by LINEAR commands their names.
    pub fn files(&self) -> BTreeMap<String, Vec<u8>> {
        let bytes = |text: &Text| text.lock().unwrap_or_else(PoisonError::into_inner).clone();
        self.texts
            .iter()
            .map(|(name, text)| (name.clone(), bytes(text)))
            .collect()
    }
}

/// Destination of an output file: a file on disk, or a text in memory.
#[derive(Debug)]
pub(super) enum Sink {
    File(BufWriter<LineEnds<File>>),
    Memory(Text),
}

impl Sink {
    pub(crate) fn file(file: LineEnds<File>) -> Self {
        Self::File(BufWriter::new(file))
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::File(file) => file.write(bytes),
            Self::Memory(text) => {
                let mut text = text.lock().unwrap_or_else(PoisonError::into_inner);
                text.extend_from_slice(bytes);
                Ok(bytes.len())
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::File(file) => file.flush(),
            Self::Memory(_) => Ok(()),
        }
    }
}
