//! Diagnostics that are kept while the text changes: their positions are relative to pieces of the file.

use admire_session::check::DiagnosticSource;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Edit, Span};

/// A diagnostic whose positions move with the text.
#[derive(Clone, Debug)]
pub(super) struct AnchoredDiagnostic {
    pub diagnostic: Diagnostic,
    /// Position of each label; `None` for labels in other files.
    pub labels: Vec<Option<Anchor>>,
    /// Position of each edit of its fix.
    pub edits: Vec<Anchor>,
}

/// A span relative to the start of a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    pub piece: u32,
    pub span: Span,
}

/// A diagnostic that may be published, with the data needed for the selection.
pub(super) struct Candidate<'a> {
    pub told: DiagnosticSource,
    pub diagnostic: &'a Diagnostic,
    /// Position of its first label in the current text.
    pub span: Option<Span>,
    /// Offset of its piece, for diagnostics of the reader.
    pub base: usize,
    pub kept: Option<&'a AnchoredDiagnostic>,
}

impl<'a> Candidate<'a> {
    /// Creates a candidate from a diagnostic of the reader about a piece that starts at `base`.
    pub(crate) fn read(diagnostic: &'a Diagnostic, base: usize) -> Self {
        let label = diagnostic.labels.first();
        let span = label.map(|label| Span::new(base + label.span.start(), base + label.span.end()));
        Self {
            told: DiagnosticSource::Reader,
            diagnostic,
            span,
            base,
            kept: None,
        }
    }

    /// Returns the code and the start offset, by which duplicates are recognised.
    pub(crate) fn place(&self) -> (Code, Option<usize>) {
        (self.diagnostic.code, self.span.map(Span::start))
    }
}

/// Returns the new position of a span after `length` bytes have replaced the span `edited`. `None` if the edit touches the span.
pub(super) fn new_place(span: Span, edited: Span, length: usize) -> Option<Span> {
    if span.end() < edited.start() {
        return Some(span);
    }
    if span.start() < edited.end() {
        return None;
    }
    let shift = |offset: usize| offset - edited.len() + length;
    Some(Span::new(shift(span.start()), shift(span.end())))
}

/// Converts a diagnostic of a piece to positions in the file.
pub(super) fn shifted(found: &Diagnostic, base: usize) -> Diagnostic {
    let mut found = found.clone();
    let shift = |span: Span| Span::new(base + span.start(), base + span.end());
    for label in &mut found.labels {
        label.span = shift(label.span);
    }
    if let Some(fix) = &mut found.fix {
        for Edit { span, .. } in &mut fix.edits {
            *span = shift(*span);
        }
    }
    found
}
