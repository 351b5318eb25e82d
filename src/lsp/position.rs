//! Places as the protocol counts them: lines from 0, and UTF-16 units within a line.

use lsp_types::{Position, Range};

use admire_syntax::pieces::Pieces;
use admire_syntax::text::Span;

/// The place of an offset. Offsets beyond the end are the end.
pub(super) fn position(pieces: &Pieces, offset: usize) -> Position {
    let Some(at) = pieces.at(offset) else {
        return Position::new(0, 0);
    };
    let piece = &pieces.pieces()[at];
    let bytes = piece.source().bytes();
    let inside = offset.saturating_sub(pieces.start(at)).min(bytes.len());
    let (mut line, mut start) = (pieces.first_line(at), 0);
    for end in line_ends(bytes) {
        if end > inside {
            break;
        }
        line += 1;
        start = end;
    }
    Position::new(line as u32, units(&bytes[start..inside]))
}

/// The range of a span.
pub(super) fn range(pieces: &Pieces, span: Span) -> Range {
    Range::new(position(pieces, span.start()), position(pieces, span.end()))
}

/// The offset of a place. What lies beyond the end of its line is that end; lines beyond the last one are the end of the file.
pub(super) fn offset(pieces: &Pieces, position: Position) -> usize {
    let line = position.line as usize;
    let Some(at) = pieces.at_line(line) else {
        return 0;
    };
    let bytes = pieces.pieces()[at].source().bytes();
    let mut start = 0;
    let wanted = line - pieces.first_line(at);
    if wanted > 0 {
        match line_ends(bytes).nth(wanted - 1) {
            Some(end) => start = end,
            None => return pieces.size(),
        }
    }
    let rest = &bytes[start..];
    let end = memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
    pieces.start(at) + start + bytes_of(&rest[..end], position.character)
}

/// The span of a range; an empty one where its end stands before its start.
pub(super) fn span(pieces: &Pieces, range: Range) -> Span {
    let start = offset(pieces, range.start);
    Span::new(start, offset(pieces, range.end).max(start))
}

/// Where the lines of one piece begin: for many places of it.
pub(super) struct PieceLines<'p> {
    bytes: &'p [u8],
    first: usize,
    starts: Vec<usize>,
}

impl<'p> PieceLines<'p> {
    /// The lines of piece `at`.
    pub(crate) fn of(pieces: &'p Pieces, at: usize) -> Self {
        let bytes = pieces.pieces()[at].source().bytes();
        Self {
            bytes,
            first: pieces.first_line(at),
            starts: std::iter::once(0).chain(line_ends(bytes)).collect(),
        }
    }

    /// The range of a span of the piece.
    pub(crate) fn range(&self, span: Span) -> Range {
        Range::new(self.position(span.start()), self.position(span.end()))
    }

    fn position(&self, offset: usize) -> Position {
        let line = self.starts.partition_point(|start| *start <= offset) - 1;
        let column = units(&self.bytes[self.starts[line]..offset.min(self.bytes.len())]);
        Position::new((self.first + line) as u32, column)
    }

    /// Every line with its number in the file, line ends included.
    pub(crate) fn texts(&self) -> impl Iterator<Item = (u32, &'p [u8])> + '_ {
        let ends = self.starts[1..].iter().copied().chain([self.bytes.len()]);
        let lines = self.starts.iter().zip(ends).enumerate();
        lines.map(|(line, (start, end))| ((self.first + line) as u32, &self.bytes[*start..end]))
    }
}

/// Where lines end, each behind its mark: LF, CR LF or a lone CR.
fn line_ends(bytes: &[u8]) -> impl Iterator<Item = usize> + '_ {
    memchr::memchr2_iter(b'\n', b'\r', bytes)
        .filter(|at| bytes[*at] == b'\n' || bytes.get(at + 1) != Some(&b'\n'))
        .map(|at| at + 1)
}

/// The text of some bytes: UTF-8, or else Latin-1.
pub(super) fn decoded(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes)
        .unwrap_or_else(|error| error.into_bytes().into_iter().map(char::from).collect())
}

/// How many UTF-16 units a text has.
fn units(text: &[u8]) -> u32 {
    if text.is_ascii() {
        return text.len() as u32;
    }
    let text = String::from_utf8_lossy(text);
    text.chars().map(|c| c.len_utf16() as u32).sum()
}

/// How many bytes the first so many UTF-16 units of a line have. A place inside of a character is its beginning.
fn bytes_of(line: &[u8], wanted: u32) -> usize {
    if line.is_ascii() {
        return line.len().min(wanted as usize);
    }
    let text = String::from_utf8_lossy(line);
    let mut units = 0;
    for (at, c) in text.char_indices() {
        units += c.len_utf16() as u32;
        if units > wanted {
            return at;
        }
    }
    line.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_syntax::grammar::Role;
    use admire_syntax::text::Source;

    #[test]
    fn lines_end_in_three_ways_and_characters_are_counted_in_utf_16() {
        let text = "t\u{e9}\r\nPART/1 ! \u{1f697}x\tend\rMARKER/1\n\nEND\n! \u{fc}";
        let pieces = Pieces::parse(&Source::new("a", text.as_bytes()), Role::Dataset);
        for (needle, line, character) in [
            ("\r\nPART", 0, 2),
            ("PART", 1, 0),
            ("\u{1f697}", 1, 9),
            ("x\t", 1, 11),
            ("end", 1, 13),
            ("MARKER", 2, 0),
            ("END", 4, 0),
            ("\u{fc}", 5, 2),
        ] {
            let at = text.find(needle).expect("there");
            let place = Position::new(line, character);
            assert_eq!(position(&pieces, at), place, "{needle:?}");
            assert_eq!(offset(&pieces, place), at, "{needle:?}");
        }
        // In the middle of the car, behind a line, behind the file.
        let car = text.find('\u{1f697}').expect("there");
        assert_eq!(offset(&pieces, Position::new(1, 10)), car);
        assert_eq!(
            offset(&pieces, Position::new(3, 9)),
            text.find("END").expect("there") - 1
        );
        assert_eq!(offset(&pieces, Position::new(99, 0)), text.len());
        assert_eq!(position(&pieces, text.len()), Position::new(5, 3));
        assert_eq!(decoded(b"t\xe9".to_vec()), "t\u{e9}");
    }
}
