//! Diagnostics about a text or a model, as data. They are independent of their output format and of the rules that report them.

mod code;

use std::sync::Arc;

pub use code::Code;

use crate::text::{Edit, Span};

/// Severity of a diagnostic.
#[derive(
    Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Information only; nothing needs to change.
    Note,
    /// The result may differ from what the user intends.
    Warning,
    /// The input cannot be used in its present form.
    Error,
}

/// A location in a file, with a message about that location.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Label {
    /// File name, as given by its [`Source`](crate::text::Source).
    pub file: Arc<str>,
    /// Smallest span that contains the problem.
    pub span: Span,
    /// Message about the location; may be empty.
    pub message: String,
}

impl Label {
    /// Returns true if the label concerns the whole file: its span is then empty and at offset 0.
    pub fn is_about_all(&self) -> bool {
        self.span == Span::at(0)
    }
}

/// Whether a fix may be applied without confirmation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Applicability {
    /// The fix keeps the meaning of the file.
    Safe,
    /// The fix may change the meaning of the file; a person must decide.
    MaybeIncorrect,
}

/// A proposed change of the file that the first label names.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Fix {
    /// Description of the fix in one line.
    pub title: String,
    /// Edits of the file, with offsets in its unchanged bytes.
    pub edits: Vec<Edit>,
    /// Whether the fix may be applied without confirmation.
    pub applicability: Applicability,
}

/// An object of a model that is the subject of a diagnostic.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Object {
    /// Keyword in capitals.
    pub kind: &'static str,
    /// Id of the object.
    pub id: u32,
    /// Name of the object as written in the message: `CONTACT/1 'cam_to_pin'`.
    pub called: String,
    /// ADAMS/View name of the object, if it adds information to keyword and id.
    pub view: Option<String>,
}

/// One diagnostic: an error, a warning or a note.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Diagnostic {
    /// Stable code, which identifies the kind of problem.
    pub code: Code,
    /// Severity of the diagnostic.
    pub severity: Severity,
    /// One sentence without a full stop.
    pub message: String,
    /// Object that the message mentions; set if no label locates the problem.
    pub object: Option<Object>,
    /// Locations of the problem, the most important first.
    pub labels: Vec<Label>,
    /// Advice on how to resolve the problem.
    pub help: Option<String>,
    /// Proposed change that resolves the problem.
    pub fix: Option<Fix>,
}

impl Diagnostic {
    /// Creates an error without a location.
    pub fn error(code: Code, message: impl Into<String>) -> Self {
        Self::new(code, Severity::Error, message)
    }

    /// Creates a warning without a location.
    pub fn warning(code: Code, message: impl Into<String>) -> Self {
        Self::new(code, Severity::Warning, message)
    }

    /// Creates a note without a location.
    pub fn note(code: Code, message: impl Into<String>) -> Self {
        Self::new(code, Severity::Note, message)
    }

    fn new(code: Code, severity: Severity, message: impl Into<String>) -> Self {
        Self {
            code,
            severity,
            message: message.into(),
            object: None,
            labels: Vec::new(),
            help: None,
            fix: None,
        }
    }

    /// Sets the object that the message mentions.
    #[must_use]
    pub fn about(mut self, object: Object) -> Self {
        self.object = Some(object);
        self
    }

    /// Adds a location in a file, with a message about it.
    #[must_use]
    pub fn label(
        mut self,
        file: impl Into<Arc<str>>,
        span: Span,
        message: impl Into<String>,
    ) -> Self {
        self.labels.push(Label {
            file: file.into(),
            span,
            message: message.into(),
        });
        self
    }

    /// Sets the advice.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Sets the proposed change.
    #[must_use]
    pub fn fix(
        mut self,
        title: impl Into<String>,
        edits: Vec<Edit>,
        applicability: Applicability,
    ) -> Self {
        self.fix = Some(Fix {
            title: title.into(),
            edits,
            applicability,
        });
        self
    }
}

/// Value and diagnostics of an operation that always gives a value, such as parsing.
#[derive(Clone, Debug)]
pub struct Checked<T> {
    /// The result, as complete as the input permits.
    pub value: T,
    /// Diagnostics found while producing the result.
    pub diagnostics: Vec<Diagnostic>,
}

impl<T> Checked<T> {
    /// Wraps a result without diagnostics.
    pub fn clean(value: T) -> Self {
        Self {
            value,
            diagnostics: Vec::new(),
        }
    }

    /// Returns true if any diagnostic is an error.
    pub fn has_errors(&self) -> bool {
        self.diagnostics
            .iter()
            .any(|diagnostic| diagnostic.severity == Severity::Error)
    }
}
