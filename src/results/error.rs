use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Span;

/// Why results cannot be read (further).
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// The file cannot be read or written.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The file is not what it should be.
    #[error("{}", .0.message)]
    Refused(Box<Diagnostic>),
}

impl ResultsError {
    /// A refusal at bytes `from..to` of a file.
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

    /// As a complaint, whichever it is.
    pub fn into_diagnostic(self) -> Diagnostic {
        match self {
            Self::Io(error) => Diagnostic::error(Code::CannotRead, error.to_string()),
            Self::Refused(diagnostic) => *diagnostic,
        }
    }
}
