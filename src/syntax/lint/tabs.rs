use super::context::Context;
use crate::TokenKind;
use crate::diagnostic::{Applicability, Code, Diagnostic};
use crate::text::{Edit, Span};

/// Reports tabs between words, once for the whole file.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let source = context.dataset.source();
    let mut edits = Vec::new();
    let mut count = 0;
    for token in context.dataset.tokens() {
        if token.kind != TokenKind::Blank {
            continue;
        }
        let mut at = token.span.start();
        for run in source
            .slice(token.span)
            .chunk_by(|a, b| (*a == b'\t') == (*b == b'\t'))
        {
            if run[0] == b'\t' {
                count += run.len();
                edits.push(Edit::new(
                    Span::new(at, at + run.len()),
                    " ".repeat(run.len()),
                ));
            }
            at += run.len();
        }
    }
    let Some(first) = edits.first().map(|edit| edit.span.start()) else {
        return;
    };
    let first = Span::new(first, first + 1);
    let message = match count {
        1 => "there is a tab between words".to_string(),
        _ => format!("there are {count} tabs between words"),
    };
    found.push(
        context
            .note(Code::Tab, first, message)
            .help("the FORTRAN solver counts a tab as one column")
            .fix("replace each tab with a blank", edits, Applicability::Safe),
    );
}
