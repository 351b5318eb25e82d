//! Complaints that are kept while the text changes: their places are those of pieces.

use admire_session::check::Told;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Edit, Span};

/// A complaint whose places move with the text.
#[derive(Clone, Debug)]
pub(super) struct Complaint {
    pub diagnostic: Diagnostic,
    /// Of each label; `None` for places in other files.
    pub labels: Vec<Option<Anchor>>,
    /// Of each edit of its fix.
    pub edits: Vec<Anchor>,
}

/// A place in a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    pub piece: u32,
    pub span: Span,
}

/// A complaint that may be told, as far as choosing needs it.
pub(super) struct Candidate<'a> {
    pub told: Told,
    pub diagnostic: &'a Diagnostic,
    /// Its own place in the file as it is now.
    pub span: Option<Span>,
    /// Where its piece begins, for what the reader complains of.
    pub base: usize,
    pub kept: Option<&'a Complaint>,
}

impl<'a> Candidate<'a> {
    /// A complaint of the reader about a piece that begins at `base`.
    pub(crate) fn read(diagnostic: &'a Diagnostic, base: usize) -> Self {
        let label = diagnostic.labels.first();
        let span = label.map(|label| Span::new(base + label.span.start(), base + label.span.end()));
        Self {
            told: Told::Reader,
            diagnostic,
            span,
            base,
            kept: None,
        }
    }

    /// What is said and where that begins.
    pub(crate) fn place(&self) -> (Code, Option<usize>) {
        (self.diagnostic.code, self.span.map(Span::start))
    }
}

/// Where a span is once as many bytes as `length` are in place of `edited`; `None` if the edit reaches it.
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

/// A complaint of a piece with its places in the file.
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
