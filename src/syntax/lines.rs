use memchr::memchr2;

use super::lexer::is_blank;
use crate::text::Span;

/// Physical lines joined by continuation marks. A logical line contains one statement, or several separated by semicolons.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct LogicalLine {
    /// Span from the first non-blank byte to the end of the last physical line; the last line end is not included.
    pub span: Span,
    /// Name given by the last `adams_view_name` comment before the logical line.
    pub view_name: Option<Span>,
}

/// One line of a file, between two line ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct PhysicalLine {
    /// Span of the line without its line end.
    pub span: Span,
    /// Offset of the next physical line.
    pub next: usize,
}

/// Returns the physical line that starts at `start`. A line ends at LF, CR LF or a single CR.
pub(super) fn physical_line(bytes: &[u8], start: usize) -> PhysicalLine {
    let end = memchr2(b'\n', b'\r', &bytes[start..]).map_or(bytes.len(), |at| start + at);
    let mark = match &bytes[end..] {
        [] => 0,
        [b'\r', b'\n', ..] => 2,
        _ => 1,
    };
    PhysicalLine {
        span: Span::new(start, end),
        next: end + mark,
    }
}

/// Returns the logical lines from offset `start` on. If `ends` is true (in a dataset), reading stops at an END line, and the end of that
/// line is returned too.
///
/// The rules follow guide/formats.md 1.3. A line is a continuation if it begins with a comma, or if the line before it ends with `&`; blank
/// lines and comment lines may lie in between. After a line that ends with a comma, the next line is also a continuation, unless it begins
/// like a statement.
pub(super) fn logical_lines(
    bytes: &[u8],
    start: usize,
    ends: bool,
) -> (Vec<LogicalLine>, Option<usize>) {
    let mut lines: Vec<LogicalLine> = Vec::new();
    let mut at = start;
    let mut view_name = None;
    let mut open = Open::No;
    while at < bytes.len() {
        let physical = physical_line(bytes, at);
        at = physical.next;
        let (start, end) = (physical.span.start(), physical.span.end());
        let Some(first) = bytes[start..end].iter().position(|byte| !is_blank(*byte)) else {
            continue;
        };
        let content = &bytes[start + first..end];
        if content[0] == b'!' {
            if let Some(name) = name_in_comment(content) {
                view_name = Some(Span::new(
                    start + first + name.start(),
                    start + first + name.end(),
                ));
            }
            continue;
        }
        let continues = open.reaches(content) && !(open == Open::No && lines.is_empty());
        match lines.last_mut() {
            Some(last) if continues => last.span = last.span.to(end),
            _ => lines.push(LogicalLine {
                span: Span::new(start + first, end),
                view_name,
            }),
        }
        view_name = None;
        open = Open::after(content);
        if ends && !continues && is_end(content) {
            return (lines, Some(end));
        }
    }
    (lines, None)
}

/// Ending of a line, which determines whether the next line continues it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Open {
    No,
    Ampersand,
    Comma,
}

impl Open {
    fn after(content: &[u8]) -> Self {
        let code = match memchr::memchr(b'!', content) {
            Some(_) => &content[..comment_start(content)],
            None => content,
        };
        match code.iter().rev().find(|byte| !is_blank(**byte)) {
            Some(b'&') => Self::Ampersand,
            Some(b',') => Self::Comma,
            _ => Self::No,
        }
    }

    /// Returns true if the next line continues a line with this ending. `content` is the next line from its first non-blank byte on.
    fn reaches(self, content: &[u8]) -> bool {
        match self {
            Self::No => content[0] == b',',
            Self::Ampersand => true,
            Self::Comma => content[0] == b',' || !begins_statement(content),
        }
    }
}

/// Returns true if the last line of `before` is continued by the first line of `next` that is neither blank nor a comment.
pub(super) fn continues(before: &[u8], next: &[u8]) -> bool {
    let start = memchr::memrchr2(b'\n', b'\r', before).map_or(0, |end| end + 1);
    let content = |line: &[u8]| line.iter().position(|byte| !is_blank(*byte));
    let open = content(&before[start..]).map_or(Open::No, |at| Open::after(&before[start + at..]));
    let mut at = 0;
    while at < next.len() {
        let line = physical_line(next, at);
        at = line.next;
        let line = &next[line.span.range()];
        if let Some(first) = content(line).filter(|first| line[*first] != b'!') {
            return open.reaches(&line[first..]);
        }
    }
    false
}

/// Returns the offset at which the comment of a line starts, or the length of the line if it has none. An exclamation mark inside quotes
/// does not start a comment.
pub(super) fn comment_start(content: &[u8]) -> usize {
    let mut quoted = false;
    content
        .iter()
        .position(|byte| {
            quoted ^= *byte == b'"';
            *byte == b'!' && !quoted
        })
        .unwrap_or(content.len())
}

/// Returns true for an END line: `END` alone, or followed by a blank, `!`, `;` or `/`.
pub(super) fn is_end(content: &[u8]) -> bool {
    content.len() >= 3
        && content[..3].eq_ignore_ascii_case(b"END")
        && content[3..]
            .iter()
            .find(|byte| !is_blank(**byte))
            .is_none_or(|byte| matches!(byte, b'!' | b';' | b'/'))
        && content
            .get(3)
            .is_none_or(|byte| is_blank(*byte) || matches!(byte, b'!' | b';' | b'/'))
}

/// Returns true if a line begins with a word and a slash, or is END. No argument at the start of a line looks like this.
fn begins_statement(content: &[u8]) -> bool {
    let word = content
        .iter()
        .position(|byte| !(byte.is_ascii_alphanumeric() || *byte == b'_'))
        .unwrap_or(content.len());
    let after = content[word..].iter().find(|byte| !is_blank(**byte));
    (word > 0 && content[0].is_ascii_alphabetic() && after == Some(&b'/')) || is_end(content)
}

/// Returns the span of NAME in the comment text `adams_view_name='NAME'`.
fn name_in_comment(comment: &[u8]) -> Option<Span> {
    const KEY: &[u8] = b"adams_view_name='";
    let quote = memchr::memchr(b'\'', comment)?;
    let start = quote + 1;
    if start < KEY.len() || !comment[start - KEY.len()..start].eq_ignore_ascii_case(KEY) {
        return None;
    }
    let length = memchr::memrchr(b'\'', &comment[start..])?;
    Some(Span::new(start, start + length))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> Vec<&str> {
        logical_lines(text.as_bytes(), 0, true)
            .0
            .iter()
            .map(|line| &text[line.span.range()])
            .collect()
    }

    #[test]
    fn continuation_crosses_comments_and_blank_lines() {
        assert_eq!(
            shown(
                "PART/1\n!c\n\n , GROUND\nVARIABLE/2 &\nFUNCTION=1,\n2\nJOINT/3,\nMARKER/4\nEND\nrest\n"
            ),
            [
                "PART/1\n!c\n\n , GROUND",
                "VARIABLE/2 &\nFUNCTION=1,\n2",
                "JOINT/3,",
                "MARKER/4",
                "END"
            ]
        );
    }

    #[test]
    fn names_stand_in_the_comment_before() {
        let text = "!  adams_view_name='a b'\r\n! adams_view_units='no_units'\r\nPART/1\r\n!x='y'\r\nPART/2";
        let (lines, end) = logical_lines(text.as_bytes(), 0, true);
        assert_eq!(&text[lines[0].view_name.unwrap().range()], "a b");
        assert_eq!(lines[1].view_name, None);
        assert_eq!(end, None);
    }
}
