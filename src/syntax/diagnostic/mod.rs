//! What to tell a person about a text or a model, as data.
//!
//! Knows neither how it is printed nor which rule found it.

mod code;

use std::sync::Arc;

pub use code::Code;

use crate::text::{Edit, Span};

/// How bad it is.
#[derive(
    Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Information.
    Note,
    /// The answer may differ from what was meant.
    Warning,
    /// The input cannot be used as it is.
    Error,
}

/// A place in a file and what is said of it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Label {
    /// The file, as named by its [`Source`](crate::text::Source).
    pub file: Arc<str>,
    /// The smallest span that shows the trouble.
    pub span: Span,
    /// What to say of this place; may be empty.
    pub message: String,
}

impl Label {
    /// True if it is about the file as a whole: an empty place in front of it.
    pub fn is_about_all(&self) -> bool {
        self.span == Span::at(0)
    }
}

/// Whether a fix may be applied without asking.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Applicability {
    /// Keeps the meaning of the file.
    Safe,
    /// May change the meaning; a person decides.
    MaybeIncorrect,
}

/// A proposed change of the file of the first label.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Fix {
    /// What the fix does, in one line.
    pub title: String,
    /// The edits, in offsets of the file as it is.
    pub edits: Vec<Edit>,
    /// Whether it may be applied without asking.
    pub applicability: Applicability,
}

/// An object of a model, as a message calls it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Object {
    /// Keyword in capitals.
    pub kind: &'static str,
    /// Its number.
    pub id: u32,
    /// As in the message: `CONTACT/1 'cam_to_pin'`.
    pub called: String,
    /// View name, where it says more than keyword and id.
    pub view: Option<String>,
}

/// One complaint.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Diagnostic {
    /// Stable kebab-case code.
    pub code: Code,
    /// How bad it is.
    pub severity: Severity,
    /// One sentence, no full stop.
    pub message: String,
    /// The object it is about, where the message names one and no place tells it.
    pub object: Option<Object>,
    /// Places, the primary one first.
    pub labels: Vec<Label>,
    /// What to do about it.
    pub help: Option<String>,
    /// A proposed change.
    pub fix: Option<Fix>,
}

impl Diagnostic {
    /// An error without a place yet.
    pub fn error(code: Code, message: impl Into<String>) -> Self {
        Self::new(code, Severity::Error, message)
    }

    /// A warning without a place yet.
    pub fn warning(code: Code, message: impl Into<String>) -> Self {
        Self::new(code, Severity::Warning, message)
    }

    /// A note without a place yet.
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

    /// Says which object it is about.
    #[must_use]
    pub fn about(mut self, object: Object) -> Self {
        self.object = Some(object);
        self
    }

    /// Adds a place.
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

    /// Says what to do.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Proposes a change.
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

/// A thing and the complaints about it: the front half of the ladder never fails.
#[derive(Clone, Debug)]
pub struct Checked<T> {
    /// The thing, as good as it could be made.
    pub value: T,
    /// What was found on the way.
    pub diagnostics: Vec<Diagnostic>,
}

impl<T> Checked<T> {
    /// A thing nobody complains about.
    pub fn clean(value: T) -> Self {
        Self {
            value,
            diagnostics: Vec::new(),
        }
    }

    /// True if any complaint is an error.
    pub fn has_errors(&self) -> bool {
        self.diagnostics
            .iter()
            .any(|diagnostic| diagnostic.severity == Severity::Error)
    }
}
