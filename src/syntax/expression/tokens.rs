use super::super::{Token, TokenKind, number::number_length};
use crate::text::Span;

/// Splits a stand-alone expression, such as a channel of a study, into tokens. Such an expression contains no comments or continuation
/// marks.
pub(super) fn tokens_of(text: &[u8]) -> Vec<Token> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while at < text.len() {
        let rest = &text[at..];
        let run = |test: fn(&u8) -> bool| rest.iter().take_while(|&byte| test(byte)).count();
        let (kind, length) = match rest[0] {
            b' ' | b'\t' | b'\r' | b'\n' => (
                TokenKind::Blank,
                run(|byte| matches!(byte, b' ' | b'\t' | b'\r' | b'\n')),
            ),
            b'A'..=b'Z' | b'a'..=b'z' | b'_' => (
                TokenKind::Word,
                run(|byte| byte.is_ascii_alphanumeric() || *byte == b'_'),
            ),
            byte => match number_length(rest) {
                0 => (TokenKind::Punctuation(byte), 1),
                length => (TokenKind::Number, length),
            },
        };
        tokens.push(Token {
            kind,
            span: Span::new(at, at + length),
        });
        at += length;
    }
    tokens
}
