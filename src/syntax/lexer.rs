use nom::bytes::complete::{tag, take, take_till, take_while};
use nom::combinator::{opt, recognize};
use nom::{IResult, Parser};

use super::number::number_length;
use super::{Token, TokenKind};
use crate::text::Span;

/// Iterator over the tokens of a text; it reads them one by one and stores none. It recognises words, marks and line ends, but not
/// statements.
///
/// The run time is linear in the length of any text: only the blanks between `&` and its line end are read twice.
#[derive(Clone, Debug)]
pub(super) struct Lexer<'a> {
    bytes: &'a [u8],
    at: usize,
    end: usize,
    /// True if only blanks have been read since the start of the line.
    line_start: bool,
}

impl<'a> Lexer<'a> {
    /// Creates a lexer for the part `span` of `bytes`. `line_start` is true if only blanks precede the span on its line.
    pub(crate) fn new(bytes: &'a [u8], span: Span, line_start: bool) -> Self {
        Self {
            bytes,
            at: span.start(),
            end: span.end(),
            line_start,
        }
    }
}

impl Lexer<'_> {
    /// Appends all remaining tokens except blanks to a list.
    #[inline]
    pub(crate) fn read_into(mut self, tokens: &mut Vec<Token>) {
        loop {
            // Half of the tokens of a deck are single blanks, so blanks are skipped in a fast loop.
            while self.at < self.end && is_blank(self.bytes[self.at]) {
                self.at += 1;
            }
            if self.at >= self.end {
                return;
            }
            let start = self.at;
            let kind = self.advance();
            let span = Span::new(start, self.at);
            tokens.push(Token { kind, span });
        }
    }

    /// Moves past the next token and returns its kind; must not be called at the end.
    #[inline]
    fn advance(&mut self) -> TokenKind {
        let (length, kind) = token(&self.bytes[self.at..self.end], self.line_start);
        self.at += length;
        match kind {
            TokenKind::LineEnd => self.line_start = true,
            TokenKind::Blank => {}
            _ => self.line_start = false,
        }
        kind
    }
}

impl Iterator for Lexer<'_> {
    type Item = Token;

    fn next(&mut self) -> Option<Token> {
        if self.at >= self.end {
            return None;
        }
        let start = self.at;
        let kind = self.advance();
        let span = Span::new(start, self.at);
        Some(Token { kind, span })
    }
}

/// Returns true for a blank: space, tab, NUL, vertical tab, form feed or the end-of-file mark ^Z.
pub(super) const fn is_blank(byte: u8) -> bool {
    CLASSES[byte as usize] & BLANK != 0
}

const fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

const fn is_word(byte: u8) -> bool {
    CLASSES[byte as usize] & WORD != 0
}

const BLANK: u8 = 1;
const WORD: u8 = 2;

/// Class of each byte; one table lookup replaces several comparisons per byte.
static CLASSES: [u8; 256] = {
    let mut classes = [0; 256];
    let mut byte = 0u8;
    loop {
        classes[byte as usize] = match byte {
            b' ' | b'\t' | 0 | 0x0b | 0x0c | 0x1a => BLANK,
            b'0'..=b'9' | b'A'..=b'Z' | b'a'..=b'z' | b'_' => WORD,
            _ => 0,
        };
        if byte == u8::MAX {
            break classes;
        }
        byte += 1;
    }
};

/// Returns the length (at least one) and kind of the first token of a non-empty input.
#[inline]
fn token(input: &[u8], line_start: bool) -> (usize, TokenKind) {
    match input[0] {
        b'A'..=b'Z' | b'a'..=b'z' | b'_' => {
            let length = input.iter().position(|byte| !is_word(*byte));
            (length.unwrap_or(input.len()), TokenKind::Word)
        }
        b'0'..=b'9' | b'.' => match number_length(input) {
            0 => punctuation(input),
            length => (length, TokenKind::Number),
        },
        b'\n' => (1, TokenKind::LineEnd),
        b'\r' => (
            1 + usize::from(input.get(1) == Some(&b'\n')),
            TokenKind::LineEnd,
        ),
        b'!' => (length(take_till(is_line_end), input), TokenKind::Comment),
        b'"' => (length(quoted, input), TokenKind::Quoted),
        b',' if line_start => (1, TokenKind::Continuation),
        b'&' if ends_line(&input[1..]) => (1, TokenKind::Continuation),
        byte if is_blank(byte) => (length(take_while(is_blank), input), TokenKind::Blank),
        _ => punctuation(input),
    }
}

const fn punctuation(input: &[u8]) -> (usize, TokenKind) {
    (1, TokenKind::Punctuation(input[0]))
}

/// Returns the number of bytes that a parsing rule consumes at the front of the input, or 1 if it consumes none.
#[inline]
fn length<'a, R>(mut rule: R, input: &'a [u8]) -> usize
where
    R: Parser<&'a [u8], Output = &'a [u8], Error = ()>,
{
    rule.parse(input).map_or(1, |(_, taken)| taken.len().max(1))
}

/// Parses a quoted text, from its opening quote to the next quote or to the end of the line.
fn quoted(input: &[u8]) -> IResult<&[u8], &[u8], ()> {
    recognize((
        take(1usize),
        take_till(|byte| byte == b'"' || is_line_end(byte)),
        opt(tag(&b"\""[..])),
    ))
    .parse(input)
}

/// Returns true if only blanks, or blanks and a comment, remain on the line.
fn ends_line(rest: &[u8]) -> bool {
    match rest.iter().find(|byte| !is_blank(**byte)) {
        None => true,
        Some(byte) => is_line_end(*byte) || *byte == b'!',
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(text: &str) -> Vec<(TokenKind, &str)> {
        Lexer::new(text.as_bytes(), Span::new(0, text.len()), true)
            .filter(|token| !matches!(token.kind, TokenKind::Blank))
            .map(|token| (token.kind, &text[token.span.range()]))
            .collect()
    }

    #[test]
    fn a_leading_comma_and_a_trailing_ampersand_continue() {
        use TokenKind::{Comment, Continuation, LineEnd, Number, Punctuation, Word};
        assert_eq!(
            kinds("K = 1,2.5E+005 & ! stiff\n , 90D"),
            [
                (Word, "K"),
                (Punctuation(b'='), "="),
                (Number, "1"),
                (Punctuation(b','), ","),
                (Number, "2.5E+005"),
                (Continuation, "&"),
                (Comment, "! stiff"),
                (LineEnd, "\n"),
                (Continuation, ","),
                (Number, "90D"),
            ]
        );
    }

    #[test]
    fn tokens_tile_any_bytes() {
        for bytes in [
            &b"\xef\xbb\xbf\"open\r\r\n.5.E1D2\x1a\0&&  &\xff"[..],
            b"",
            b"&",
            b"..",
            b"\r",
        ] {
            let mut at = 0;
            for token in Lexer::new(bytes, Span::new(0, bytes.len()), true) {
                assert_eq!(token.span.start(), at);
                assert!(!token.span.is_empty());
                at = token.span.end();
            }
            assert_eq!(at, bytes.len());
        }
    }
}
