use super::context::Context;
use crate::diagnostic::{Applicability, Code, Diagnostic};
use crate::syntax::TokenKind;
use crate::text::{Edit, Span};

/// Tabs between words, once for the file.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let source = context.dataset.source();
    let mut edits = Vec::new();
    for token in context.dataset.tokens() {
        if token.kind != TokenKind::Blank {
            continue;
        }
        for (at, byte) in source.slice(token.span).iter().enumerate() {
            if *byte == b'\t' {
                let place = token.span.start() + at;
                edits.push(Edit::new(Span::new(place, place + 1), " "));
            }
        }
    }
    let Some(first) = edits.first().map(|edit| edit.span) else {
        return;
    };
    let message = format!("{} tabs stand between words", edits.len());
    found.push(
        context
            .note(Code::Tab, first, message)
            .help("the FORTRAN solver counts a tab as one column")
            .fix("write a blank for each tab", edits, Applicability::Safe),
    );
}
