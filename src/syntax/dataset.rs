use crate::grammar::{ArgumentDef, StatementDef};
use crate::text::Span;

use super::Expression;

/// What a token is. Tokens tile the bytes of the file: each starts where the one before ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TokenKind {
    /// The first line of a dataset.
    Title,
    /// A letter or underscore and what follows of letters, digits, underscores.
    Word,
    /// A number, with its degree suffix if it has one.
    Number,
    /// `"..."`.
    Quoted,
    /// One of `/ = , : \ ( ) + - * ; &` or any other single byte.
    Punctuation(u8),
    /// A comma that only marks a continuation line (first on its line).
    Continuation,
    /// Free text of a TITLE, COMMENT, STRING or file name argument.
    Text,
    /// Blanks and tabs.
    Blank,
    /// A line end: LF, CR LF, or a lone CR.
    LineEnd,
    /// `!` to the end of the line.
    Comment,
    /// Everything after END.
    AfterEnd,
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

/// What stands after the equals sign of an argument.
#[derive(Clone, PartialEq, Debug)]
pub enum Value {
    /// Nothing: a flag.
    Flag,
    /// Numbers, integers or ids.
    Numbers(Vec<Number>),
    /// Words: one or several choices, with their spans.
    Words(Vec<Span>),
    /// One or several texts (quotes not included in the spans).
    Texts(Vec<Span>),
    /// A FUNCTION expression.
    Function(Expression),
    /// `USER(...)`: the span of the whole call.
    User(Span),
    /// Something that does not fit the grammar; a diagnostic says why.
    Malformed(Span),
}

/// One argument of a statement.
#[derive(Clone, PartialEq, Debug)]
pub struct Argument {
    /// Its definition, if the grammar knows it.
    pub def: Option<&'static ArgumentDef>,
    /// The keyword as typed.
    pub name: Span,
    /// From the keyword to the end of the value.
    pub span: Span,
    /// The value.
    pub value: Value,
}

/// One statement or command.
#[derive(Clone, PartialEq, Debug)]
pub struct Statement {
    /// Its definition, if the grammar knows it.
    pub def: Option<&'static StatementDef>,
    /// The keyword as typed.
    pub keyword: Span,
    /// Id and where it stands.
    pub id: Option<(u32, Span)>,
    /// From the keyword to the end of the last argument.
    pub span: Span,
    /// Indices of its tokens, from the keyword's to the last one's.
    pub tokens: std::ops::Range<usize>,
    /// Arguments in the order they are written.
    pub arguments: Vec<Argument>,
    /// The name in the `adams_view_name` comment before it.
    pub view_name: Option<String>,
}
