use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Span;

/// Reason why a results file cannot be read, or cannot be read to its end.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// The file could not be read or written.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The content of the file is invalid.
    #[error("{}", .0.message)]
    Refused(Box<Diagnostic>),
}

impl ResultsError {
    /// Creates an error that refers to the bytes `from..to` of a file.
    pub(super) fn refused(
        code: Code,
        file: &str,
        from: u64,
        to: u64,
        message: impl Into<String>,
    ) -> Self {
        let span = Span::new(from as usize, to.max(from) as usize);
        let mut diagnostic = Diagnostic::error(code, message);
        if span.start() as u64 != from {
            diagnostic.message += &format!(" (at byte {from})");
        }
        Self::Refused(Box::new(diagnostic.label(file, span, "")))
    }

    /// Converts the error into a diagnostic.
    pub fn into_diagnostic(self) -> Diagnostic {
        match self {
            Self::Io(error) => Diagnostic::error(Code::CannotRead, error.to_string()),
            Self::Refused(diagnostic) => *diagnostic,
        }
    }
}
