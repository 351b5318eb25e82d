use std::fmt;
use std::io;
use std::path::Path;

use admire_session::{Sources, located};
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};

/// Error of an operation, with the same diagnostics as the command line, located in their files.
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
    /// An address, a column or an option is invalid here.
    Usage,
    /// There is no equilibrium, no motion or no fit.
    NoAnswer,
    /// A file cannot be read or written.
    File(io::ErrorKind),
}

/// Diagnostic with resolved places.
#[derive(Clone, PartialEq, Debug, serde::Serialize, serde::Deserialize)]
pub struct Complaint {
    /// Stable code, for example `undefined-id`.
    pub code: Code,
    /// Severity.
    pub severity: Severity,
    /// Message in one sentence.
    pub message: String,
    /// Suggested remedy.
    pub help: Option<String>,
    /// Places, the main place first.
    pub places: Vec<Place>,
    /// Complete text, with the line of the file and the place marked.
    pub text: String,
}

/// Place in a file.
#[derive(Clone, PartialEq, Eq, Debug, serde::Serialize, serde::Deserialize)]
pub struct Place {
    /// File, as it was named.
    pub file: String,
    /// Offset of the first byte.
    pub start: usize,
    /// Offset past the last byte.
    pub end: usize,
    /// Line, from 1; `None` if the text is not available.
    pub line: Option<usize>,
    /// Column in bytes, from 1; `None` if the text is not available.
    pub column: Option<usize>,
    /// Message for this place.
    pub message: String,
}

impl Complaint {
    /// Creates a complaint with its places in these files.
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
    /// Creates an error from diagnostics, sorted by severity.
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
