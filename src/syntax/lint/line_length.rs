use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};
use crate::text::Span;

/// Columns the FORTRAN solver reads.
const COLUMNS: usize = 80;

/// Lines the FORTRAN solver would cut off. Comments are its own affair.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    if !context.options.fortran {
        return;
    }
    let mut start = 0;
    for line in context.dataset.bytes().split(|byte| *byte == b'\n') {
        let text = line.strip_suffix(b"\r").unwrap_or(line);
        if text.len() > COLUMNS && !text.starts_with(b"!") {
            let message = format!("this line has {} columns", text.len());
            let span = Span::new(start + COLUMNS, start + text.len());
            found.push(
                context
                    .warning(Code::LineTooLong, span, message)
                    .help("the FORTRAN solver reads 80 columns"),
            );
        }
        start += line.len() + 1;
    }
}
