use crate::text::Span;

/// What a token is. Tokens tile the bytes of the file: each starts where the one before ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TokenKind {
    /// The first line of a dataset, without its line end.
    Title,
    /// A letter or underscore and what follows of letters, digits, underscores.
    Word,
    /// A number without its sign, with its degree suffix if it has one.
    Number,
    /// `"..."`; a quote that is never closed ends with its line.
    Quoted,
    /// One of `/ = , : \ ( ) + - * ; &` or any other single byte.
    Punctuation(u8),
    /// A mark that only continues a line: a comma that stands first on its line, or `&` that stands last.
    Continuation,
    /// The two prompt-style first lines of a command file.
    Text,
    /// Blanks, tabs, and the control bytes old systems leave in files.
    Blank,
    /// A line end: LF, CR LF, or a lone CR.
    LineEnd,
    /// `!` to the end of the line.
    Comment,
    /// Everything after END.
    AfterEnd,
}

impl TokenKind {
    /// True for what means nothing to a statement: blanks, line ends, comments, and what stands outside of all statements.
    pub const fn is_trivia(self) -> bool {
        matches!(
            self,
            Self::Blank | Self::LineEnd | Self::Comment | Self::Title | Self::Text | Self::AfterEnd
        )
    }
}

/// One token.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Token {
    /// What it is.
    pub kind: TokenKind,
    /// Where it stands.
    pub span: Span,
}

/// A number as written.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Number {
    /// Its value; degrees are turned into radians.
    pub value: f64,
    /// True if it carries the degree suffix.
    pub degrees: bool,
    /// Where it stands, sign and suffix included.
    pub span: Span,
}

impl Number {
    /// It as an id, if it can be one.
    pub fn as_id(&self) -> Option<u32> {
        as_id(self.value)
    }
}

/// A value as an id, if it can be one. Zero stands for ground or for nothing and is none.
pub fn as_id(value: f64) -> Option<u32> {
    let whole = value.fract() == 0.0 && (1.0..=f64::from(u32::MAX)).contains(&value);
    whole.then_some(value as u32)
}
