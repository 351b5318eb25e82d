use crate::text::Span;

/// Kind of a token. The tokens of a file cover all of its bytes: each token starts where the preceding token ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TokenKind {
    /// The first line of a dataset, without its line end.
    Title,
    /// A letter or underscore, followed by letters, digits and underscores.
    Word,
    /// A number without its sign, including a degree suffix.
    Number,
    /// A text in quotes, `"..."`. If the closing quote is missing, the text ends at the end of the line.
    Quoted,
    /// One of `/ = , : \ ( ) + - * ; &`, or any other single byte.
    Punctuation(u8),
    /// A mark that only continues a line: a comma at the start of a line, or `&` at its end.
    Continuation,
    /// One of the two prompt-style first lines of a command file.
    Text,
    /// Blanks, tabs, and control bytes that old systems left in files.
    Blank,
    /// A line end: LF, CR LF, or a CR alone.
    LineEnd,
    /// A comment, from `!` to the end of the line.
    Comment,
    /// Everything after END.
    AfterEnd,
}

impl TokenKind {
    /// Returns true for tokens that have no meaning inside a statement: blanks, line ends, comments, and tokens outside of all statements.
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
    /// Kind of the token.
    pub kind: TokenKind,
    /// Location of the token.
    pub span: Span,
}

/// A number written in a file.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Number {
    /// Value of the number; degrees are converted to radians.
    pub value: f64,
    /// True if the number has the degree suffix.
    pub degrees: bool,
    /// Location of the number, including its sign and suffix.
    pub span: Span,
}

impl Number {
    /// Returns the number as an id, or `None` if it is not a valid id.
    pub fn as_id(&self) -> Option<u32> {
        as_id(self.value)
    }
}

/// Returns a value as an id, or `None` if it is not a valid id. Zero is not a valid id; it means ground or no object.
pub fn as_id(value: f64) -> Option<u32> {
    let whole = value.fract() == 0.0 && (1.0..=f64::from(u32::MAX)).contains(&value);
    whole.then_some(value as u32)
}
