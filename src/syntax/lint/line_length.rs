use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};
use crate::lines::comment_start;
use crate::text::Span;

/// Number of columns of a line that the FORTRAN solver reads.
const COLUMNS: usize = 80;

/// Returns the length of a line without its comment, in columns.
fn code_length(line: &[u8]) -> usize {
    match comment_start(line) {
        at if at < line.len() => line[..at].trim_ascii_end().len(),
        _ => line.len(),
    }
}

/// Reports lines that the FORTRAN solver would truncate. Lines are not reported if only their comment exceeds the limit.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    if !context.options.fortran {
        return;
    }
    let mut start = 0;
    for line in context.dataset.bytes().split(|byte| *byte == b'\n') {
        let text = line.strip_suffix(b"\r").unwrap_or(line);
        // Truncation of a comment does no harm.
        if code_length(text) > COLUMNS {
            let message = format!("this line has {} columns", text.len());
            let span = Span::new(start + COLUMNS, start + text.len());
            found.push(context.warning(Code::LineTooLong, span, message).help(
                "the FORTRAN solver reads 80 columns; continue on a line that begins with a comma",
            ));
        }
        start += line.len() + 1;
    }
}
