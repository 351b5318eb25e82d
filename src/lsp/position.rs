//! Positions of the protocol: lines counted from 0, columns in UTF-16 units.

use lsp_types::{Position, Range};

use admire_syntax::pieces::Pieces;
use admire_syntax::text::Span;

/// Converts an offset to a position. An offset beyond the end of the file becomes the end of the file.
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

/// Converts a span to a range.
pub(super) fn range(pieces: &Pieces, span: Span) -> Range {
    Range::new(position(pieces, span.start()), position(pieces, span.end()))
}

/// Converts a position to an offset. A column beyond the end of its line becomes the end of that line. A line beyond the last line becomes
/// the end of the file.
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

/// Converts a range to a span. If the end precedes the start, the span is empty.
pub(super) fn span(pieces: &Pieces, range: Range) -> Span {
    let start = offset(pieces, range.start);
    Span::new(start, offset(pieces, range.end).max(start))
}

/// Line starts of one piece, for converting many spans.
pub(super) struct PieceLines<'p> {
    bytes: &'p [u8],
    first: usize,
    starts: Vec<usize>,
}

impl<'p> PieceLines<'p> {
    /// Finds the lines of piece `at`.
    pub(crate) fn of(pieces: &'p Pieces, at: usize) -> Self {
        let bytes = pieces.pieces()[at].source().bytes();
        Self {
            bytes,
            first: pieces.first_line(at),
            starts: std::iter::once(0).chain(line_ends(bytes)).collect(),
        }
    }

    /// Converts a span of the piece to a range.
    pub(crate) fn range(&self, span: Span) -> Range {
        Range::new(self.position(span.start()), self.position(span.end()))
    }

    fn position(&self, offset: usize) -> Position {
        let line = self.starts.partition_point(|start| *start <= offset) - 1;
        let column = units(&self.bytes[self.starts[line]..offset.min(self.bytes.len())]);
        Position::new((self.first + line) as u32, column)
    }

    /// Returns every line with its number in the file, line ends included.
    pub(crate) fn texts(&self) -> impl Iterator<Item = (u32, &'p [u8])> + '_ {
        let ends = self.starts[1..].iter().copied().chain([self.bytes.len()]);
        let lines = self.starts.iter().zip(ends).enumerate();
        lines.map(|(line, (start, end))| ((self.first + line) as u32, &self.bytes[*start..end]))
    }
}

/// Returns the offset after each line end: LF, CR LF or a lone CR.
fn line_ends(bytes: &[u8]) -> impl Iterator<Item = usize> + '_ {
    memchr::memchr2_iter(b'\n', b'\r', bytes)
        .filter(|at| bytes[*at] == b'\n' || bytes.get(at + 1) != Some(&b'\n'))
        .map(|at| at + 1)
}

/// Decodes bytes as UTF-8, or as Latin-1 if they are not valid UTF-8. (Latin-1 decoding never fails.)
pub(super) fn decoded(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes)
        .unwrap_or_else(|error| error.into_bytes().into_iter().map(char::from).collect())
}

/// Returns the length of a text in UTF-16 units.
fn units(text: &[u8]) -> u32 {
    if text.is_ascii() {
        return text.len() as u32;
    }
    let text = String::from_utf8_lossy(text);
    text.chars().map(|c| c.len_utf16() as u32).sum()
}

/// Returns the number of bytes in the first `wanted` UTF-16 units of a line. If unit number `wanted` ends inside a character, that
/// character is not counted.
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
        // The cases are: inside the car character, beyond the end of a line, beyond the end of the file.
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
