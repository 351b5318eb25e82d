//! Diagnostics that are kept while the text changes. Their positions are relative to pieces of the file (runs of whole lines parsed
//! separately).

use admire_session::check::DiagnosticSource;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Edit, Span};

/// A diagnostic whose positions move with the text.
#[derive(Clone, Debug)]
pub(super) struct AnchoredDiagnostic {
    pub diagnostic: Diagnostic,
    /// Position of each label; `None` for a label in another file.
    pub labels: Vec<Option<Anchor>>,
    /// Position of each edit in the diagnostic's fix.
    pub edits: Vec<Anchor>,
}

/// A span relative to the start of the piece with this key.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    pub piece: u32,
    pub span: Span,
}

/// A diagnostic that may be published, with the data for this decision.
pub(super) struct Candidate<'a> {
    pub told: DiagnosticSource,
    pub diagnostic: &'a Diagnostic,
    /// Position of the diagnostic's first label in the current text.
    pub span: Option<Span>,
    /// For a diagnostic of the reader, the offset in the file of the piece to which the diagnostic belongs; zero for other diagnostics.
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

    /// Returns the code and the start offset. Two diagnostics with the same code and start are duplicates.
    pub(crate) fn place(&self) -> (Code, Option<usize>) {
        (self.diagnostic.code, self.span.map(Span::start))
    }
}

/// Returns the position of a span after `length` bytes have replaced the bytes in `edited`. `None` if the edit touches the span.
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

/// Converts a diagnostic with positions relative to its piece into a diagnostic with positions in the file.
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
