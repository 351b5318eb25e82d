use std::sync::Arc;

use super::fix::did_you_mean;
use super::number::parse_number;
use super::parser::{Cursor, StatementParser};
use super::{Number, Shared, Token, TokenKind, Value, expression};
use crate::diagnostic::{Applicability, Code, Diagnostic};
use crate::grammar::{
    ArgumentDef, Choice, Lookup, StatementDef, ValueKind, all_nearest, find_choice,
};
use crate::text::{Edit, Span};

/// Error that a list of numbers could not be parsed.
struct NotNumbers;

impl StatementParser<'_> {
    /// Parses the value of an argument after its keyword.
    pub(super) fn value(
        &mut self,
        statement: Option<&'static StatementDef>,
        def: Option<&'static ArgumentDef>,
        name: Span,
        cursor: &mut Cursor,
    ) -> Value {
        let equals = cursor.take_mark(b'=');
        let Some(def) = def else {
            return if equals {
                self.unknown_value(cursor)
            } else {
                Value::Flag
            };
        };
        match (def.kind, equals) {
            (ValueKind::Flag, false) => Value::Flag,
            (ValueKind::Flag, true) => {
                let value = self.unknown_value(cursor);
                let word = def.name;
                let function = statement.and_then(|statement| statement.argument("FUNCTION"));
                let help = if function.is_some_and(|f| f.kind == ValueKind::Function) {
                    format!(
                        "{word} is a flag without a value, and the expression belongs to FUNCTION: write `{word}, FUNCTION=` before it"
                    )
                } else {
                    format!("{word} is a flag: write it without `=`")
                };
                let message = format!("{word} takes no value");
                let diagnostic = Diagnostic::error(Code::WrongCount, message).help(help);
                self.complain(diagnostic, name, "");
                value
            }
            (_, false) => {
                let diagnostic =
                    Diagnostic::error(Code::WrongCount, format!("{} needs a value", def.name));
                self.complain(diagnostic, name, "");
                Value::Flag
            }
            (ValueKind::Real | ValueKind::Integer | ValueKind::Reference(_), true) => {
                self.known_numbers(def, cursor)
            }
            (ValueKind::Choice(choices), true) => self.choice(def, choices, cursor),
            (ValueKind::Function, true) => self.function(statement, def, cursor),
            (ValueKind::Text | ValueKind::File, true) => {
                self.texts(statement, cursor, def.count.max != Some(1))
            }
            (ValueKind::TextList, true) => self.texts(statement, cursor, true),
        }
    }

    fn known_numbers(&mut self, def: &'static ArgumentDef, cursor: &mut Cursor) -> Value {
        cursor.skip_continuation();
        let start = cursor.position();
        if let Ok(numbers) = self.numbers(cursor) {
            return Value::Numbers(numbers);
        }
        let first = cursor
            .since(start)
            .iter()
            .find(|token| !token.kind.is_trivia())
            .copied();
        let last = self.list.last().map(|number| number.span);
        let bad = cursor
            .since(start)
            .iter()
            .find(|token| {
                last.is_some_and(|last| token.span.start() >= last.end())
                    && !token.kind.is_trivia()
                    && !matches!(
                        token.kind,
                        TokenKind::Continuation | TokenKind::Punctuation(b',')
                    )
            })
            .copied();
        let rest = cursor.skip_value();
        let rest = bad.map_or(rest, |token| token.span.join(rest));
        let span = match (last, first) {
            (Some(last), _) => {
                // A text that follows a number without a comma is reported together with that number.
                let between = self.source.slice(Span::new(last.end(), rest.start()));
                if between.contains(&b',') {
                    rest
                } else {
                    last.join(rest)
                }
            }
            (None, Some(token)) => token.span.join(rest),
            (None, None) => rest,
        };
        let mut whole = first.map_or(span, |token| token.span.join(span));
        let is_one = def.count.max == Some(1);
        let wanted = match def.kind {
            ValueKind::Integer if is_one => "a whole number".to_string(),
            ValueKind::Integer => "whole numbers".to_string(),
            ValueKind::Reference(space) if is_one => format!("the id of one {space}"),
            ValueKind::Reference(space) => format!("ids of kind {space}"),
            _ if is_one => "a number".to_string(),
            _ => "numbers".to_string(),
        };
        let code = match first {
            Some(_) => Code::BadNumber,
            None => Code::WrongType,
        };
        let mut diagnostic = Diagnostic::error(code, format!("{} takes {wanted}", def.name));
        if has_d_exponent(self.source.slice(span)) {
            diagnostic =
                diagnostic.help("D after a number means degrees; write a power of ten with E");
        }
        let blanks = self.source.text(span);
        let mut separate = blanks.split_ascii_whitespace();
        if blanks.contains(' ') && separate.all(|word| parse_number(word.as_bytes()).is_some()) {
            diagnostic = diagnostic.help("separate the values with commas");
        }
        self.complain(diagnostic, span, "");
        // Numbers after the fault still belong to the value; they must not be parsed as arguments or reported again.
        loop {
            let end = cursor.position();
            let more = cursor.skip_commas()
                && cursor.peek().is_some_and(|token| {
                    matches!(
                        token.kind,
                        TokenKind::Number | TokenKind::Punctuation(b'+' | b'-')
                    )
                });
            if !more {
                cursor.go_back(end);
                return Value::Malformed(whole);
            }
            whole = whole.join(cursor.skip_value());
        }
    }

    /// Parses numbers separated by commas, up to the first separator that is not followed by a number. After an error, the cursor is at the
    /// fault.
    fn numbers(&mut self, cursor: &mut Cursor) -> Result<Shared<Number>, NotNumbers> {
        self.list.clear();
        loop {
            let number = self.number(cursor).ok_or(NotNumbers)?;
            self.list.push(number);
            let end = cursor.position();
            let separated = cursor.skip_commas();
            match cursor.peek().map(|token| token.kind) {
                Some(TokenKind::Number | TokenKind::Punctuation(b'+' | b'-')) if separated => {}
                None | Some(TokenKind::Punctuation(b'\\')) => {
                    cursor.go_back(end);
                    return Ok(self.all_numbers.share(self.list.iter().copied()));
                }
                Some(_) if separated => {
                    cursor.go_back(end);
                    return Ok(self.all_numbers.share(self.list.iter().copied()));
                }
                Some(_) => return Err(NotNumbers),
            }
        }
    }

    /// Parses a number with an optional sign and an optional degree suffix: `[+|-] number [D]`.
    fn number(&self, cursor: &mut Cursor) -> Option<Number> {
        let first = cursor.peek()?;
        let signed = matches!(first.kind, TokenKind::Punctuation(b'+' | b'-'));
        if signed {
            cursor.advance();
        }
        let digits = cursor
            .peek()
            .filter(|token| token.kind == TokenKind::Number)?;
        cursor.advance();
        let (mut value, mut degrees) = parse_number(self.source.slice(digits.span))?;
        let mut span = first.span.join(digits.span);
        // Some hand-written decks have a blank before the degree suffix.
        if let Some(word) = cursor.peek()
            && word.kind == TokenKind::Word
            && !degrees
            && self.source.slice(word.span).eq_ignore_ascii_case(b"D")
        {
            cursor.advance();
            value = value.to_radians();
            degrees = true;
            span = span.join(word.span);
        }
        if first.kind == TokenKind::Punctuation(b'-') {
            value = -value;
        }
        Some(Number {
            value,
            degrees,
            span,
        })
    }

    /// Parses words joined by colons. Parentheses around them are accepted, because the documentation page of FRICTION shows them.
    fn choice(
        &mut self,
        def: &'static ArgumentDef,
        choices: &'static [Choice],
        cursor: &mut Cursor,
    ) -> Value {
        cursor.skip_continuation();
        let bracketed = cursor.take_mark(b'(');
        let mut words = Vec::new();
        loop {
            let Some(word) = choice_word(cursor) else {
                let span = cursor.skip_value();
                self.complain_choice(def, choices, span);
                return Value::Malformed(span);
            };
            if !matches!(
                find_choice(choices, self.source.slice(word)),
                Lookup::Found(_)
            ) {
                self.complain_choice(def, choices, word);
            }
            words.push(word);
            if !cursor.take_mark(b':') {
                break;
            }
            cursor.skip_continuation();
        }
        if bracketed && !cursor.take_mark(b')') {
            let span = cursor.skip_value();
            self.complain_choice(def, choices, span);
            return Value::Malformed(span);
        }
        Value::Words(words)
    }

    fn complain_choice(&mut self, def: &ArgumentDef, choices: &'static [Choice], span: Span) {
        let typed = self.source.text(span).into_owned();
        let names = || choices.iter().map(|choice| choice.name);
        let near = if typed.len() <= 32 {
            all_nearest(&typed, names())
        } else {
            Vec::new()
        };
        let shown: String = typed.chars().take(40).collect();
        let wrong = Diagnostic::error(Code::WrongType, format!("{} cannot be {shown}", def.name));
        let diagnostic = if near.is_empty() {
            let all = names().collect::<Vec<_>>().join(", ");
            wrong.help(format!("write one of {all}"))
        } else {
            did_you_mean(wrong, span, &near)
        };
        self.complain(diagnostic, span, "");
    }

    /// Parses a FUNCTION up to a backslash or a comma outside of parentheses. A line end alone does not end the function.
    fn function(
        &mut self,
        statement: Option<&'static StatementDef>,
        def: &'static ArgumentDef,
        cursor: &mut Cursor,
    ) -> Value {
        cursor.skip_continuation();
        let start = cursor.position();
        let mut depth = 0usize;
        while let Some(token) = cursor.peek() {
            match token.kind {
                TokenKind::Punctuation(b'(' | b'[') => depth += 1,
                TokenKind::Punctuation(b')' | b']') => depth = depth.saturating_sub(1),
                TokenKind::Punctuation(b'\\') => break,
                TokenKind::Punctuation(b',') if depth == 0 => break,
                TokenKind::Continuation
                    if depth == 0
                        && self.source.slice(token.span) == b","
                        && self.is_assignment(statement, &cursor.rest()[1..]) =>
                {
                    let end = cursor
                        .since(start)
                        .iter()
                        .rfind(|token| !token.kind.is_trivia())
                        .map_or(token.span.start(), |token| token.span.end());
                    let diagnostic = Diagnostic::warning(
                        Code::SyntaxError,
                        format!(
                            "{} must end with a backslash, because another argument follows",
                            def.name
                        ),
                    )
                    .fix(
                        "end the function with a backslash",
                        vec![Edit::new(Span::at(end), "\\")],
                        Applicability::Safe,
                    );
                    self.complain(diagnostic, token.span, "");
                    break;
                }
                _ => {}
            }
            cursor.advance();
        }
        let mut tokens = cursor.since(start);
        while let [front @ .., last] = tokens
            && (last.kind.is_trivia() || last.kind == TokenKind::Continuation)
        {
            tokens = front;
        }
        let (Some(first), Some(last)) = (tokens.first(), tokens.last()) else {
            let span = Span::at(cursor.place(start));
            let diagnostic =
                Diagnostic::error(Code::BadExpression, format!("{} is empty", def.name));
            self.complain(diagnostic, span, "");
            return Value::Malformed(span);
        };
        let span = first.span.join(last.span);
        if self.is_user_call(tokens) {
            return Value::User(span);
        }
        let parsed = expression::parse(self.source, tokens, span);
        self.diagnostics.extend(parsed.diagnostics);
        match parsed.value {
            Some(expression) => Value::Function(Arc::new(expression)),
            None => Value::Malformed(span),
        }
    }

    fn is_user_call(&self, tokens: &[Token]) -> bool {
        let mut meaningful = tokens.iter().filter(|token| !token.kind.is_trivia());
        meaningful
            .next()
            .is_some_and(|token| self.source.slice(token.span).eq_ignore_ascii_case(b"USER"))
            && meaningful
                .next()
                .is_some_and(|token| token.kind == TokenKind::Punctuation(b'('))
    }

    /// Returns true if the tokens begin with `KEYWORD =` and KEYWORD is an argument of the statement.
    fn is_assignment(
        &mut self,
        statement: Option<&'static StatementDef>,
        tokens: &[Token],
    ) -> bool {
        let mut meaningful = tokens.iter().filter(|token| !token.kind.is_trivia());
        let (Some(word), Some(next)) = (meaningful.next(), meaningful.next()) else {
            return false;
        };
        word.kind == TokenKind::Word
            && next.kind == TokenKind::Punctuation(b'=')
            && statement.is_some_and(|statement| {
                self.keywords
                    .argument(statement, self.source.slice(word.span))
                    .is_ok()
            })
    }

    /// Returns true if the tokens after a comma begin the next argument, false if they continue the current text.
    ///
    /// The next argument is either any word with an equals sign, or a flag of the statement with nothing after it.
    fn is_next_argument(
        &mut self,
        statement: Option<&'static StatementDef>,
        tokens: &[Token],
    ) -> bool {
        let mut meaningful = tokens.iter().filter(|token| !token.kind.is_trivia());
        let Some(word) = meaningful.next() else {
            return true;
        };
        if word.kind != TokenKind::Word {
            return false;
        }
        match meaningful.next().map(|token| token.kind) {
            Some(TokenKind::Punctuation(b'=')) => true,
            None | Some(TokenKind::Continuation | TokenKind::Punctuation(b',' | b'\\')) => {
                statement.is_some_and(|statement| {
                    self.keywords
                        .argument(statement, self.source.slice(word.span))
                        .is_ok_and(|def| def.kind == ValueKind::Flag)
                })
            }
            Some(_) => false,
        }
    }

    /// Parses free text: either quoted texts separated by commas, or unquoted text up to the end of the line or the next argument.
    ///
    /// If `list` is true, unquoted text is split at colons and commas.
    fn texts(
        &mut self,
        statement: Option<&'static StatementDef>,
        cursor: &mut Cursor,
        list: bool,
    ) -> Value {
        let mut texts = Vec::new();
        let mut at = cursor.place(cursor.position());
        loop {
            match cursor.peek() {
                Some(token) if token.kind == TokenKind::Quoted => {
                    cursor.advance();
                    texts.push(self.unquoted(token.span));
                    at = token.span.end();
                }
                Some(token) if token.kind == TokenKind::Continuation && texts.is_empty() => {
                    // The text begins on the next line, unless that line begins the next argument; in that case the text is empty.
                    let position = cursor.position();
                    cursor.advance();
                    if !self.is_next_argument(statement, cursor.rest()) {
                        continue;
                    }
                    cursor.go_back(position);
                    break;
                }
                Some(_) => {
                    at = self
                        .line_of_text(statement, cursor, list, &mut texts)
                        .unwrap_or(at);
                }
                None => break,
            }
            // After a comma, another text of the list may follow.
            let end = cursor.position();
            let several = list || self.source.bytes().get(at.wrapping_sub(1)) == Some(&b'"');
            if !several || !cursor.skip_commas() || self.is_next_argument(statement, cursor.rest())
            {
                cursor.go_back(end);
                break;
            }
        }
        if texts.is_empty() {
            texts.push(Span::at(at));
        }
        Value::Texts(texts)
    }

    /// Parses unquoted text on the current line and returns the offset at which it ends.
    fn line_of_text(
        &mut self,
        statement: Option<&'static StatementDef>,
        cursor: &mut Cursor,
        list: bool,
        texts: &mut Vec<Span>,
    ) -> Option<usize> {
        let mut item: Option<Span> = None;
        let mut end = None;
        let mut passed = 0;
        let mut continued = false;
        for (index, token) in cursor.rest().iter().enumerate() {
            match token.kind {
                TokenKind::LineEnd | TokenKind::Comment | TokenKind::Continuation => {
                    continued = true;
                    break;
                }
                TokenKind::Punctuation(b',')
                    if list || self.is_next_argument(statement, &cursor.rest()[index + 1..]) =>
                {
                    break;
                }
                TokenKind::Punctuation(b':') if list && self.is_single_colon(token.span) => {
                    texts.push(item.take().unwrap_or(Span::at(token.span.start())));
                    end = Some(token.span.end());
                    item = Some(Span::at(token.span.end()));
                }
                TokenKind::Blank => {}
                _ => {
                    item = Some(match item {
                        Some(span) if !span.is_empty() => span.join(token.span),
                        _ => token.span,
                    });
                    end = Some(token.span.end());
                }
            }
            passed = index + 1;
        }
        // If the line ends with a colon, the next text of the list begins on the next line.
        texts.extend(item.filter(|span| !(continued && span.is_empty())));
        cursor.go_back(cursor.position() + passed);
        end
    }

    /// Returns true for a single colon, which separates texts; the double colon in `library::subroutine` belongs to a text.
    fn is_single_colon(&self, span: Span) -> bool {
        let bytes = self.source.bytes();
        bytes.get(span.end()) != Some(&b':')
            && (span.start() == 0 || bytes[span.start() - 1] != b':')
    }

    /// Returns the span of a quoted text without its quotes.
    fn unquoted(&self, span: Span) -> Span {
        let closed = span.len() > 1 && self.source.bytes()[span.end() - 1] == b'"';
        Span::new(span.start() + 1, span.end() - usize::from(closed))
    }

    /// Parses the value of an unknown argument: as numbers if possible, otherwise as text up to the next separator.
    fn unknown_value(&mut self, cursor: &mut Cursor) -> Value {
        cursor.skip_continuation();
        let start = cursor.position();
        if let Ok(numbers) = self.numbers(cursor) {
            return Value::Numbers(numbers);
        }
        cursor.go_back(start);
        Value::Texts(vec![cursor.skip_value()])
    }
}

/// Returns true if a number in the text has an exponent in FORTRAN style: `1.5D3`, `1D+05`.
fn has_d_exponent(text: &[u8]) -> bool {
    text.windows(3).any(|three| {
        (three[0].is_ascii_digit() || three[0] == b'.')
            && matches!(three[1], b'D' | b'd')
            && (three[2].is_ascii_digit() || matches!(three[2], b'+' | b'-'))
    })
}

/// Parses one word of a choice; it may begin with digits, as 3DBEAM does.
fn choice_word(cursor: &mut Cursor) -> Option<Span> {
    let is_piece = |token: &Token| matches!(token.kind, TokenKind::Word | TokenKind::Number);
    let mut span = cursor.peek().filter(is_piece)?.span;
    cursor.advance();
    while let Some(next) = cursor.peek().filter(is_piece)
        && next.span.start() == span.end()
    {
        span = span.to(next.span.end());
        cursor.advance();
    }
    Some(span)
}
