use std::fmt;
use std::io;
use std::path::Path;

use admire_session::{Sources, located};
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};

/// Error of an operation. It contains the same diagnostics as the command line shows, with their places in the files.
#[derive(Clone, Debug)]
pub struct Error {
    /// Kind of error.
    pub kind: ErrorKind,
    /// Diagnostics, errors first.
    pub complaints: Vec<Complaint>,
}

/// Kind of an [`Error`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ErrorKind {
    /// A deck, command file, study or results file has errors.
    Input,
    /// An address, a column or an option is invalid for this deck, run or study.
    Usage,
    /// There is no equilibrium, no motion or no fit.
    NoAnswer,
    /// A file cannot be read or written.
    File(io::ErrorKind),
}

/// Diagnostic with resolved places: file, line and column.
#[derive(Clone, PartialEq, Debug, serde::Serialize, serde::Deserialize)]
pub struct Complaint {
    /// Stable code of the diagnostic, for example `undefined-id`.
    pub code: Code,
    /// Severity.
    pub severity: Severity,
    /// Message in one sentence.
    pub message: String,
    /// Suggested remedy.
    pub help: Option<String>,
    /// Places of the fault, the main place first.
    pub places: Vec<Place>,
    /// Complete text of the diagnostic, with the line of the file and the place marked.
    pub text: String,
}

/// Place in a file.
#[derive(Clone, PartialEq, Eq, Debug, serde::Serialize, serde::Deserialize)]
pub struct Place {
    /// Name of the file, as the user or another file named it.
    pub file: String,
    /// Byte offset of the place's first byte.
    pub start: usize,
    /// Byte offset after the place's last byte.
    pub end: usize,
    /// Line number, from 1; `None` if the text of the file is not available.
    pub line: Option<usize>,
    /// Column in bytes, from 1; `None` if the text of the file is not available.
    pub column: Option<usize>,
    /// Message about this place.
    pub message: String,
}

impl Complaint {
    /// Creates a complaint. Its places are resolved in the texts of `sources`.
    pub(crate) fn new(diagnostic: &Diagnostic, sources: &Sources) -> Self {
        let place = |label: &admire_syntax::diagnostic::Label| {
            let source = sources.get(&label.file);
            let at = source.map(|source| source.line_column(label.span.start()));
            Place {
                file: label.file.to_string(),
                start: label.span.start(),
                end: label.span.end(),
                line: at.map(|at| at.line),
                column: at.map(|at| at.column),
                message: label.message.clone(),
            }
        };
        Self {
            code: diagnostic.code,
            severity: diagnostic.severity,
            message: diagnostic.message.clone(),
            help: diagnostic.help.clone(),
            places: diagnostic.labels.iter().map(place).collect(),
            text: located(diagnostic, sources),
        }
    }
}

impl Error {
    /// Creates an error from diagnostics. The complaints are sorted by severity, the most severe first.
    pub(crate) fn new(kind: ErrorKind, diagnostics: &[Diagnostic], sources: &Sources) -> Self {
        let mut complaints: Vec<Complaint> = diagnostics
            .iter()
            .map(|diagnostic| Complaint::new(diagnostic, sources))
            .collect();
        complaints.sort_by_key(|complaint| std::cmp::Reverse(complaint.severity));
        Self { kind, complaints }
    }

    /// Creates an error without a place.
    pub(crate) fn plain(kind: ErrorKind, diagnostic: &Diagnostic) -> Self {
        Self::new(kind, std::slice::from_ref(diagnostic), &Sources::default())
    }

    /// Creates the error for a file that cannot be read.
    pub(crate) fn unreadable(path: &Path, error: &io::Error) -> Self {
        let message = format!("`{}` cannot be read: {error}", path.display());
        let diagnostic = Diagnostic::error(Code::CannotRead, message);
        Self::plain(ErrorKind::File(error.kind()), &diagnostic)
    }

    /// Creates the error for a file that cannot be written.
    pub(crate) fn unwritable(path: &Path, error: &io::Error) -> Self {
        let message = format!("`{}` cannot be written: {error}", path.display());
        let diagnostic = Diagnostic::error(Code::CannotWrite, message);
        Self::plain(ErrorKind::File(error.kind()), &diagnostic)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let worst = self.complaints.iter().map(|c| c.severity).max();
        let told: Vec<&str> = self
            .complaints
            .iter()
            .filter(|complaint| Some(complaint.severity) == worst)
            .map(|complaint| complaint.text.trim_end())
            .collect();
        f.write_str(&told.join("\n"))
    }
}

impl std::error::Error for Error {}
