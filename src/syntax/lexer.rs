use nom::bytes::complete::{tag, take, take_till, take_while};
use nom::combinator::{opt, recognize};
use nom::{IResult, Parser};

use super::number::number_length;
use super::{Token, TokenKind};
use crate::text::Span;

/// Reads bytes into tokens, one after the other, without storing them. Knows lines and marks, not statements.
///
/// Time is linear for any bytes: nothing is read twice but the blanks between `&` and its line end.
#[derive(Clone, Debug)]
pub(super) struct Lexer<'a> {
    bytes: &'a [u8],
    at: usize,
    end: usize,
    /// True while only blanks were read of the line.
    line_start: bool,
}

impl<'a> Lexer<'a> {
    /// Reads `span` of `bytes`. `line_start` says that nothing but blanks stands before it on its line.
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
    /// Reads all tokens but blanks to the end of a list.
    #[inline]
    pub(crate) fn read_into(mut self, tokens: &mut Vec<Token>) {
        loop {
            // Half of the pieces of a deck are single blanks.
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

    /// Passes one token; there is one.
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

/// Blanks: also NUL, vertical tab, form feed and the end-of-file mark ^Z.
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

/// What each byte can be: one look instead of several comparisons for each byte of a file.
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

/// One token from the front of bytes that are not empty: how many of them, at least one, and what they are.
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

/// How many bytes a rule takes from the front; one if it takes none.
#[inline]
fn length<'a, R>(mut rule: R, input: &'a [u8]) -> usize
where
    R: Parser<&'a [u8], Output = &'a [u8], Error = ()>,
{
    rule.parse(input).map_or(1, |(_, taken)| taken.len().max(1))
}

/// From a quote to the next one, or to the end of the line.
fn quoted(input: &[u8]) -> IResult<&[u8], &[u8], ()> {
    recognize((
        take(1usize),
        take_till(|byte| byte == b'"' || is_line_end(byte)),
        opt(tag(&b"\""[..])),
    ))
    .parse(input)
}

/// True if nothing but blanks and a comment stands before the line end.
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
