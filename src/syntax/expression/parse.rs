use std::borrow::Cow;

use super::super::{Number, Token, TokenKind, number::parse_number};
use super::tokens::tokens_of;
use super::{BinaryOperator, Constant, Expression, Node};
use crate::diagnostic::{Checked, Code, Diagnostic};
use crate::fix::did_you_mean;
use crate::grammar::{Count, FUNCTIONS, FunctionDef, all_nearest, find_function};
use crate::text::{Source, Span};

/// Maximum nesting depth of parentheses, calls and signs.
const DEEPEST_NESTING: usize = 300;
/// Maximum height of the tree; a sum of n terms has height n. The limit bounds the stack depth of every recursive tree walk.
const DEEPEST_TREE: usize = 1000;
/// Maximum length of an unknown name for which similar names are suggested.
const LONGEST_NAME: usize = 24;

/// Parses the tokens of one function text into an expression; the grammar is in guide/formats.md 3.1.
///
/// Blanks, line ends, comments and continuation marks only separate tokens. `span` is the location of the whole text; errors at the end of
/// the text are located there. Parsing stops at the first error, and the value is then `None`.
pub fn parse(source: &Source, tokens: &[Token], span: Span) -> Checked<Option<Expression>> {
    let belongs = |token: &Token| is_significant(token) && span.contains(token.span);
    let tokens = if tokens.iter().all(belongs) {
        Cow::Borrowed(tokens)
    } else {
        Cow::Owned(tokens.iter().copied().filter(belongs).collect())
    };
    let numbers = tokens
        .iter()
        .filter(|token| token.kind == TokenKind::Number)
        .count();
    let mut parser = Parser {
        source,
        tokens: &tokens,
        at: 0,
        span,
        nesting: 0,
        literals: Vec::with_capacity(numbers),
    };
    match parser.whole() {
        Ok(root) => Checked::clean(Some(Expression {
            root,
            text: text_of(source, &tokens),
            span,
            literals: parser.literals,
        })),
        Err(diagnostic) => Checked {
            value: None,
            diagnostics: vec![*diagnostic],
        },
    }
}

impl Expression {
    /// Parses a stand-alone expression, such as `AX(21,1)*RTOD` in a study. All spans in the result are offsets in `text`.
    ///
    /// # Errors
    /// Returns `bad-expression`, located in a file named `expression` whose content is `text`.
    pub fn parse_str(text: &str) -> Result<Self, Diagnostic> {
        let source = Source::new("expression", text.as_bytes().to_vec());
        let span = Span::new(0, text.len());
        let checked = parse(&source, &tokens_of(text.as_bytes()), span);
        let mut diagnostics = checked.diagnostics.into_iter();
        match (checked.value, diagnostics.next()) {
            (Some(expression), _) => Ok(expression),
            (None, Some(diagnostic)) => Err(diagnostic),
            (None, None) => unreachable!("an expression that is not returned has a diagnostic"),
        }
    }
}

fn is_significant(token: &Token) -> bool {
    !matches!(
        token.kind,
        TokenKind::Blank
            | TokenKind::LineEnd
            | TokenKind::Comment
            | TokenKind::Continuation
            // Here `&` can only be the continuation mark at the end of a line.
            | TokenKind::Punctuation(b'&')
    )
}

/// Returns the text of the tokens, with each run of blanks, comments and continuation marks replaced by one blank.
fn text_of(source: &Source, tokens: &[Token]) -> String {
    let long = tokens.iter().map(|token| token.span.len() + 1).sum();
    let mut text = Vec::with_capacity(long);
    let mut end = None;
    for token in tokens {
        if end.is_some_and(|end| end != token.span.start()) {
            text.push(b' ');
        }
        text.extend_from_slice(source.slice(token.span));
        end = Some(token.span.end());
    }
    // A parsed expression contains only ASCII.
    String::from_utf8(text)
        .unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned())
}

/// A node, with the height of the tree below it.
type Grown = (Node, usize);
type Parsed<T> = Result<T, Box<Diagnostic>>;

struct Parser<'a> {
    source: &'a Source,
    tokens: &'a [Token],
    at: usize,
    span: Span,
    nesting: usize,
    literals: Vec<Number>,
}

impl Parser<'_> {
    fn whole(&mut self) -> Parsed<Node> {
        if self.tokens.is_empty() {
            return Err(self.error(self.span, "the expression is empty"));
        }
        let (root, _) = self.sum()?;
        match self.peek() {
            None => Ok(root),
            Some(token) => Err(self.unexpected(token)),
        }
    }

    /// Parses `term { (+|-) term }`.
    fn sum(&mut self) -> Parsed<Grown> {
        let mut left = self.product()?;
        loop {
            let operator = match self.punctuation() {
                Some(b'+') => BinaryOperator::Add,
                Some(b'-') => BinaryOperator::Subtract,
                _ => return Ok(left),
            };
            self.at += 1;
            let right = self.product()?;
            left = self.binary(operator, left, right)?;
        }
    }

    /// Parses `factor { (*|/|%) factor }`; `%` is the cross product.
    fn product(&mut self) -> Parsed<Grown> {
        let mut left = self.factor()?;
        loop {
            let operator = match self.punctuation() {
                Some(b'*') => BinaryOperator::Multiply,
                Some(b'/') => BinaryOperator::Divide,
                Some(b'%') => BinaryOperator::Cross,
                _ => return Ok(left),
            };
            self.at += 1;
            let right = self.factor()?;
            left = self.binary(operator, left, right)?;
        }
    }

    /// Parses `[+|-] power`; several signs in a row are accepted.
    fn factor(&mut self) -> Parsed<Grown> {
        let minus = match self.punctuation() {
            Some(b'+') => false,
            Some(b'-') => true,
            _ => return self.power(),
        };
        self.at += 1;
        let (inner, height) = self.nested(Self::factor)?;
        if minus {
            Ok((Node::Negate(Box::new(inner)), height + 1))
        } else {
            Ok((inner, height))
        }
    }

    /// Parses `primary [ ** factor ]`, which is right associative; blanks may separate the two stars.
    fn power(&mut self) -> Parsed<Grown> {
        let base = self.primary()?;
        let star = TokenKind::Punctuation(b'*');
        if self.kind(0) != Some(star) || self.kind(1) != Some(star) {
            return Ok(base);
        }
        self.at += 2;
        let exponent = self.nested(Self::factor)?;
        self.binary(BinaryOperator::Power, base, exponent)
    }

    fn primary(&mut self) -> Parsed<Grown> {
        let Some(token) = self.peek() else {
            return Err(self.error(
                Span::at(self.span.end()),
                "the expression ends where an operand is expected",
            ));
        };
        match token.kind {
            TokenKind::Number => {
                self.at += 1;
                self.literal(token.span)
            }
            TokenKind::Word => {
                self.at += 1;
                self.name(token.span)
            }
            TokenKind::Punctuation(b'(') => {
                self.at += 1;
                if let Some(span) = self.negative_number() {
                    self.at += 3;
                    return self.literal(span);
                }
                let inner = self.nested(Self::sum)?;
                self.expect(b')', token.span)?;
                Ok(inner)
            }
            TokenKind::Punctuation(b'[') => self.nested(|parser| parser.vector(token.span)),
            _ => Err(self.unexpected(token)),
        }
    }

    /// Parses a vector `[x, y, z]`, a notation of the C++ solver (page `operators.html`).
    fn vector(&mut self, opened: Span) -> Parsed<Grown> {
        self.at += 1;
        let (x, a) = self.sum()?;
        self.expect(b',', opened)?;
        let (y, b) = self.sum()?;
        self.expect(b',', opened)?;
        let (z, c) = self.sum()?;
        self.expect(b']', opened)?;
        let height = self.height(a.max(b).max(c))?;
        Ok((Node::Vector(Box::new([x, y, z])), height))
    }

    /// Returns the span of a negative number such as `-1.5` if the next tokens are such a number and a closing parenthesis.
    ///
    /// Such a number becomes a single literal. A literal can therefore be set to a negative value and read back.
    fn negative_number(&self) -> Option<Span> {
        let [minus, number, close] = self.tokens.get(self.at..self.at + 3)? else {
            return None;
        };
        (minus.kind == TokenKind::Punctuation(b'-')
            && number.kind == TokenKind::Number
            && close.kind == TokenKind::Punctuation(b')')
            && minus.span.end() == number.span.start())
        .then(|| minus.span.join(number.span))
    }

    fn literal(&mut self, span: Span) -> Parsed<Grown> {
        let Some((value, degrees)) = parse_number(self.source.slice(span)) else {
            return Err(self.error(span, format!("{} is not a number", self.shown(span))));
        };
        self.literals.push(Number {
            value,
            degrees,
            span,
        });
        Ok((Node::Literal(self.literals.len() - 1), 1))
    }

    /// Parses a constant, a name without arguments, an IF, or a function call, after its name was consumed.
    fn name(&mut self, span: Span) -> Parsed<Grown> {
        let source = self.source;
        let name = source.slice(span);
        let is = |word: &[u8]| name.eq_ignore_ascii_case(word);
        let call = self.punctuation() == Some(b'(');
        let constant = match name.len() {
            2 if is(b"PI") => Some(Constant::Pi),
            4 if is(b"RTOD") => Some(Constant::Rtod),
            4 if is(b"DTOR") => Some(Constant::Dtor),
            _ => None,
        };
        if let (Some(constant), false) = (constant, call) {
            return Ok((Node::Constant(constant), 1));
        }
        if call && is(b"IF") {
            return self.nested(|parser| parser.choice(span));
        }
        let Some(function) = find_function(name) else {
            return Err(self.unknown(span, name));
        };
        if call {
            self.nested(|parser| parser.call(function, span))
        } else if function.count.min == 0 {
            Ok((Node::Name(function), 1))
        } else {
            Err(self.error(
                span,
                format!(
                    "{0} needs arguments: {0}({1})",
                    function.name, function.arguments
                ),
            ))
        }
    }

    /// Parses the rest of `IF(test: negative, zero, positive)`, after the name IF was consumed.
    fn choice(&mut self, name: Span) -> Parsed<Grown> {
        self.at += 1;
        let (test, a) = self.sum()?;
        if !matches!(self.punctuation(), Some(b':')) {
            let here = self
                .peek()
                .map_or(Span::at(self.span.end()), |token| token.span);
            return Err(self.error(
                here,
                "a colon is expected after the test of IF: IF(test: negative, zero, positive)",
            ));
        }
        self.at += 1;
        let (negative, b) = self.sum()?;
        self.expect(b',', name)?;
        let (zero, c) = self.sum()?;
        self.expect(b',', name)?;
        let (positive, d) = self.sum()?;
        self.expect(b')', name)?;
        let height = self.height(a.max(b).max(c).max(d))?;
        Ok((Node::If(Box::new([test, negative, zero, positive])), height))
    }

    /// Parses the arguments of a function call, after the name of the function was consumed.
    fn call(&mut self, function: &'static FunctionDef, name: Span) -> Parsed<Grown> {
        self.at += 1;
        let mut arguments = Vec::with_capacity(function.count.min.max(2));
        let mut deepest = 0;
        if self.punctuation() != Some(b')') {
            loop {
                let (argument, height) = self.sum()?;
                arguments.push(argument);
                deepest = deepest.max(height);
                if self.punctuation() != Some(b',') {
                    break;
                }
                self.at += 1;
            }
        }
        let end = self.expect(b')', name)?;
        let span = name.join(end);
        let Count { min, max } = function.count;
        if arguments.len() < min || max.is_some_and(|max| arguments.len() > max) {
            return Err(self.error(
                span,
                format!(
                    "{} has {}, its form is {}({})",
                    function.name,
                    match arguments.len() {
                        1 => "1 argument".to_string(),
                        n => format!("{n} arguments"),
                    },
                    function.name,
                    function.arguments
                ),
            ));
        }
        let height = self.height(deepest)?;
        Ok((
            Node::Call {
                function,
                arguments,
                span,
            },
            height,
        ))
    }

    fn binary(&self, operator: BinaryOperator, left: Grown, right: Grown) -> Parsed<Grown> {
        let height = self.height(left.1.max(right.1))?;
        Ok((
            Node::Binary(operator, Box::new(left.0), Box::new(right.0)),
            height,
        ))
    }

    /// Returns the height of a node, given the height of its highest child, or an error if the height exceeds [`DEEPEST_TREE`].
    fn height(&self, child: usize) -> Parsed<usize> {
        if child < DEEPEST_TREE {
            Ok(child + 1)
        } else {
            Err(self.error(
                self.here(),
                format!("the expression has more than {DEEPEST_TREE} operations in one chain"),
            ))
        }
    }

    fn nested<T>(&mut self, inside: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        if self.nesting == DEEPEST_NESTING {
            return Err(self.error(
                self.here(),
                format!("the expression is nested more than {DEEPEST_NESTING} levels deep"),
            ));
        }
        self.nesting += 1;
        let parsed = inside(self)?;
        self.nesting -= 1;
        Ok(parsed)
    }

    fn peek(&self) -> Option<Token> {
        self.tokens.get(self.at).copied()
    }

    fn kind(&self, ahead: usize) -> Option<TokenKind> {
        self.tokens.get(self.at + ahead).map(|token| token.kind)
    }

    fn punctuation(&self) -> Option<u8> {
        match self.kind(0) {
            Some(TokenKind::Punctuation(byte)) => Some(byte),
            _ => None,
        }
    }

    fn here(&self) -> Span {
        self.peek()
            .map_or(Span::at(self.span.end()), |token| token.span)
    }

    /// Consumes the expected punctuation mark. If the expression ends before the mark, the error is located at `opened`, the opening mark.
    fn expect(&mut self, byte: u8, opened: Span) -> Parsed<Span> {
        match self.peek() {
            Some(token) if token.kind == TokenKind::Punctuation(byte) => {
                self.at += 1;
                Ok(token.span)
            }
            Some(token) => {
                let mut error = self.unexpected(token);
                error.help = Some(format!("`{}` is expected here", char::from(byte)));
                Err(error)
            }
            None => Err(self.error(
                opened,
                format!(
                    "`{}` is missing before the expression ends",
                    char::from(byte)
                ),
            )),
        }
    }

    fn unexpected(&self, token: Token) -> Box<Diagnostic> {
        let mut error = self.error(
            token.span,
            format!("{} is not expected here", self.shown(token.span)),
        );
        let after_number = self.at > 0 && self.tokens[self.at - 1].kind == TokenKind::Number;
        error.help = match token.kind {
            TokenKind::Punctuation(b'^') => Some("write ** for a power".to_string()),
            TokenKind::Punctuation(b'{') => Some("use round parentheses".to_string()),
            TokenKind::Word
                if after_number && self.source.slice(token.span).eq_ignore_ascii_case(b"D") =>
            {
                Some("the degree suffix must follow its number directly: 20D".to_string())
            }
            TokenKind::Word | TokenKind::Number | TokenKind::Punctuation(b'(') if self.at > 0 => {
                Some("an operator is missing before it".to_string())
            }
            _ => None,
        };
        error
    }

    fn unknown(&self, span: Span, name: &[u8]) -> Box<Diagnostic> {
        let mut error = self.error(span, format!("there is no function {}", self.shown(span)));
        if name.len() <= LONGEST_NAME {
            let typed = String::from_utf8_lossy(name);
            let known = FUNCTIONS
                .iter()
                .map(|function| function.name)
                .chain(["IF", "PI", "RTOD", "DTOR"]);
            let near = all_nearest(&typed, known);
            if !near.is_empty() {
                *error = did_you_mean(*error, span, &near);
            }
        }
        error
    }

    /// Returns the text of a span, shortened for use in a message.
    fn shown(&self, span: Span) -> String {
        let short = Span::new(
            span.start(),
            span.end().min(span.start() + 2 * LONGEST_NAME),
        );
        let dots = if short == span { "" } else { "..." };
        format!("`{}{dots}`", self.source.text(short))
    }

    fn error(&self, span: Span, message: impl Into<String>) -> Box<Diagnostic> {
        Box::new(Diagnostic::error(Code::BadExpression, message).label(
            self.source.name(),
            span,
            "",
        ))
    }
}
