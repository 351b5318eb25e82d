use super::fix::did_you_mean;
use super::keywords::{Keywords, Missed};
use super::lexer::Lexer;
use super::lines::LogicalLine;
use super::shared::Pool;
use super::{Argument, Number, Shared, Statement, Token, TokenKind, Value};
use crate::diagnostic::{Applicability, Code, Diagnostic, Severity};
use crate::grammar::{ArgumentDef, Role, StatementDef, ValueKind, find_statement};
use crate::text::{Edit, Source, Span};

/// Maximum number of diagnostics per statement; without a limit, every word of a garbled statement might be reported.
const MOST_COMPLAINTS: usize = 50;

/// Maximum number of diagnostics kept by one parser, which reads a few thousand lines; without a limit, a garbled file might fill the
/// memory.
const MOST_OF_A_PARSER: usize = 500;

/// Parser that turns logical lines into statements with the help of the grammar tables. Values of arguments are parsed in `value.rs`.
pub(super) struct StatementParser<'a> {
    pub(super) source: &'a Source,
    pub(super) keywords: Keywords,
    pub(super) diagnostics: Vec<Diagnostic>,
    /// Number of the diagnostics that were not kept, and their highest severity.
    pub(super) dropped: (usize, Severity),
    role: Role,
    complaints: usize,
    /// Definition of the preceding statement. A line that lacks its leading comma may contain an argument of this statement.
    pub(super) before: Option<&'static StatementDef>,
    /// True once this parser has read the keyword of a statement; `before` then describes that statement.
    pub(super) knows_before: bool,
    /// Buffer for the tokens of one line; it is reused for all lines.
    tokens: Vec<Token>,
    /// Buffer for one list of numbers; it is reused for all lists.
    pub(super) list: Vec<Number>,
    /// Buffer for the arguments of one statement; it is reused for all statements.
    found: Vec<Argument>,
    /// Numbers in all statements parsed since the last [`close`](Self::close).
    pub(super) all_numbers: Pool<Number>,
    all_arguments: Pool<Argument>,
}

impl<'a> StatementParser<'a> {
    pub(crate) fn new(source: &'a Source, role: Role) -> Self {
        Self {
            source,
            keywords: Keywords::new(role),
            diagnostics: Vec::new(),
            dropped: (0, Severity::Note),
            role,
            complaints: 0,
            before: None,
            knows_before: false,
            tokens: Vec::new(),
            list: Vec::new(),
            found: Vec::new(),
            all_numbers: Pool::new(),
            all_arguments: Pool::new(),
        }
    }

    /// Ends a group of lines. The arguments of statements parsed since the previous call are empty until this call.
    pub(crate) fn close(&mut self) {
        self.all_numbers.close();
        self.all_arguments.close();
    }

    /// Parses a logical line into one statement, or into several if it contains semicolons. A semicolon belongs to the statement before it.
    pub(crate) fn line(&mut self, line: LogicalLine, statements: &mut Vec<Statement>) {
        let mut tokens = std::mem::take(&mut self.tokens);
        tokens.clear();
        // Blank tokens are left out; gaps between spans show which tokens are separated.
        Lexer::new(self.source.bytes(), line.span, true).read_into(&mut tokens);
        if memchr::memchr(b';', self.source.slice(line.span)).is_none() {
            if let Some(start) = tokens.iter().position(|token| !token.kind.is_trivia()) {
                statements.push(self.statement(&tokens[start..], line.view_name));
            }
            self.tokens = tokens;
            return;
        }
        let first = statements.len();
        let mut view_name = line.view_name;
        for piece in tokens.split_inclusive(|token| token.kind == TokenKind::Punctuation(b';')) {
            let (piece, semicolon) = match piece.split_last() {
                Some((last, front)) if last.kind == TokenKind::Punctuation(b';') => {
                    (front, Some(last.span))
                }
                _ => (piece, None),
            };
            let Some(start) = piece.iter().position(|token| !token.kind.is_trivia()) else {
                match (semicolon, statements[first..].last_mut()) {
                    (Some(mark), Some(last)) => last.span = last.span.to(mark.end()),
                    (Some(mark), None) => statements.push(Statement {
                        def: None,
                        keyword: mark,
                        id: None,
                        span: mark,
                        arguments: Shared::default(),
                        view_name: None,
                    }),
                    (None, _) => {}
                }
                continue;
            };
            let mut statement = self.statement(&piece[start..], view_name.take());
            if let Some(mark) = semicolon {
                statement.span = statement.span.to(mark.end());
            }
            statements.push(statement);
        }
        self.tokens = tokens;
    }

    /// Parses one statement from its tokens. The first token must not be trivia.
    fn statement(&mut self, tokens: &[Token], view_name: Option<Span>) -> Statement {
        self.complaints = 0;
        let last = tokens
            .iter()
            .rfind(|token| !token.kind.is_trivia())
            .map_or(tokens[0].span, |token| token.span);
        let mut statement = Statement {
            def: None,
            keyword: tokens[0].span,
            id: None,
            span: tokens[0].span.join(last),
            arguments: Shared::default(),
            view_name,
        };
        if tokens[0].kind != TokenKind::Word {
            let mut diagnostic = Diagnostic::error(
                Code::SyntaxError,
                format!("a {} begins with its keyword", self.noun()),
            );
            if let Some(before) = self.before {
                diagnostic = diagnostic.help(format!(
                    "if the line belongs to the {} above, begin it with a comma",
                    before.name
                ));
            }
            self.complain(diagnostic, tokens[0].span, "");
            return statement;
        }
        if let Some(argument) = self.lost_comma(tokens) {
            self.without_comma(argument, statement.keyword);
            return statement;
        }
        statement.def = self.keyword(tokens[0].span);
        self.before = statement.def;
        self.knows_before = true;
        let mut cursor = Cursor::new(tokens);
        cursor.advance();
        if cursor.take_mark(b'/') {
            self.id(&mut statement, &mut cursor);
        }
        if let (Some(def), None) = (statement.def, statement.id)
            && def.id.is_some()
        {
            self.complain(
                Diagnostic::error(
                    Code::SyntaxError,
                    format!("{} needs an id: {}/1", def.name, def.name),
                ),
                statement.keyword,
                "",
            );
        }
        self.arguments(&mut statement, &mut cursor);
        statement
    }

    /// If a line lacks its leading comma and begins with an argument of the preceding statement (`QP = 1, 2, 3`), returns that argument.
    fn lost_comma(&mut self, tokens: &[Token]) -> Option<&'static ArgumentDef> {
        let before = self.before?;
        let typed = self.source.slice(tokens[0].span);
        let mark = tokens[1..]
            .iter()
            .find(|token| !token.kind.is_trivia())
            .map(|token| token.kind);
        match mark {
            Some(TokenKind::Punctuation(b'=')) => self.keywords.argument(before, typed).ok(),
            // The argument may be a flag, alone or before other arguments. END is excluded because it ends a dataset.
            None | Some(TokenKind::Punctuation(b','))
                if !typed.eq_ignore_ascii_case(b"END")
                    && self.keywords.statement(typed).is_err() =>
            {
                let argument = self.keywords.argument(before, typed).ok()?;
                (argument.kind == ValueKind::Flag).then_some(argument)
            }
            _ => None,
        }
    }

    /// Reports a line that should begin with a comma because it continues the preceding statement.
    fn without_comma(&mut self, argument: &'static ArgumentDef, name: Span) {
        let before = self.before.map_or("", |before| before.name);
        let diagnostic = Diagnostic::error(
            Code::UnknownStatement,
            format!(
                "{} is an argument of the {before} above, but this line does not continue it",
                argument.name
            ),
        )
        .help("a line that continues a statement begins with a comma, or the one before it ends with &")
        .fix(
            "begin the line with a comma",
            vec![Edit::new(Span::at(name.start()), ", ")],
            Applicability::MaybeIncorrect,
        );
        self.complain(diagnostic, name, "");
    }

    fn keyword(&mut self, span: Span) -> Option<&'static StatementDef> {
        let typed = self.source.slice(span);
        match self.keywords.statement(typed) {
            Ok(def) => Some(def),
            Err(_) if self.role == Role::Dataset && typed.eq_ignore_ascii_case(b"END") => None,
            Err(missed) if self.is_full(missed.severity()) => None,
            Err(Missed::Ambiguous(names)) => {
                let diagnostic = Diagnostic::error(
                    Code::AmbiguousKeyword,
                    format!(
                        "{} is the beginning of several keywords",
                        self.source.text(span)
                    ),
                )
                .help(format!("write one of {}", names.join(", ")));
                self.complain(diagnostic, span, "");
                None
            }
            Err(Missed::Unknown(near)) => {
                let typed = self
                    .source
                    .text(Span::new(span.start(), span.end().min(span.start() + 80)));
                let noun = self.noun();
                let of_datasets = self.role == Role::Command
                    && find_statement(self.source.slice(span), Role::Dataset)
                        .found()
                        .is_some_and(|def| def.name == "RESULTS");
                let assigned = self.role == Role::Dataset && is_assigned(self.source, span);
                let diagnostic = if of_datasets {
                    // RESULTS takes effect only in a dataset; in a command file it is ignored.
                    Diagnostic::warning(
                        Code::UnknownStatement,
                        format!("{typed} is not a {noun}; it has an effect only in a dataset"),
                    )
                } else if near.is_empty() && assigned {
                    // A word followed by an equals sign cannot begin a statement, even if ADAMS has a statement with this keyword.
                    Diagnostic::error(
                        Code::UnknownStatement,
                        format!("{typed} is not a statement"),
                    )
                    .help("an argument belongs inside its statement, as in ACCGRAV/KGRAV=-9806.65; a line that continues one begins with a comma")
                } else if near.is_empty() {
                    Diagnostic::error(
                        Code::UnknownStatement,
                        format!("{typed} is not a known {noun}; it is kept but has no effect"),
                    )
                    .help("real ADAMS stops at an unknown keyword")
                } else {
                    let message = format!("{typed} is not a {noun}");
                    did_you_mean(
                        Diagnostic::error(Code::UnknownStatement, message),
                        span,
                        &near,
                    )
                };
                self.complain(diagnostic, span, "");
                None
            }
        }
    }

    const fn noun(&self) -> &'static str {
        match self.role {
            Role::Command => "command",
            Role::Dataset | Role::Both => "statement",
        }
    }

    fn id(&mut self, statement: &mut Statement, cursor: &mut Cursor) {
        let Some(token) = cursor.peek() else {
            return;
        };
        if token.kind != TokenKind::Number {
            return;
        }
        cursor.advance();
        let digits = self.source.slice(token.span);
        let id = std::str::from_utf8(digits)
            .ok()
            .filter(|text| text.bytes().all(|byte| byte.is_ascii_digit()))
            .and_then(|text| text.parse().ok());
        statement.id = id.map(|id| (id, token.span));
        if id.is_none() {
            let diagnostic = Diagnostic::error(
                Code::BadNumber,
                format!(
                    "{} is not an id: ids are whole numbers up to {}",
                    self.source.text(token.span),
                    u32::MAX
                ),
            );
            self.complain(diagnostic, token.span, "");
        }
    }

    fn arguments(&mut self, statement: &mut Statement, cursor: &mut Cursor) {
        let mut reported = false;
        loop {
            cursor.skip_separators();
            let Some(token) = cursor.peek() else {
                statement.arguments = self.all_arguments.share(self.found.drain(..));
                return;
            };
            if token.kind == TokenKind::Word {
                cursor.advance();
                let argument = self.argument(statement.def, token.span, cursor);
                self.found.push(argument);
                continue;
            }
            let span = cursor.skip_value();
            if !reported && statement.def.is_some() {
                reported = true;
                let diagnostic = Diagnostic::error(
                    Code::SyntaxError,
                    "the keyword of an argument is expected here",
                );
                self.complain(diagnostic, span, "");
            }
        }
    }

    fn argument(
        &mut self,
        statement: Option<&'static StatementDef>,
        name: Span,
        cursor: &mut Cursor,
    ) -> Argument {
        let def = statement.and_then(|statement| self.argument_keyword(statement, name));
        let value = self.value(statement, def, name, cursor);
        let mut argument = Argument {
            def,
            name,
            span: name,
            value,
        };
        let end = match &argument.value {
            // The numbers of the value cannot be read before the pool is closed, but `list` contains the same numbers.
            Value::Numbers(_) => self.list.last().map_or(0, |number| number.span.end()),
            _ => argument.value_span().end(),
        };
        argument.span = name.to(name.end().max(end));
        argument
    }

    fn argument_keyword(
        &mut self,
        statement: &'static StatementDef,
        span: Span,
    ) -> Option<&'static ArgumentDef> {
        let typed = self.source.slice(span);
        let diagnostic = match self.keywords.argument(statement, typed) {
            Ok(def) => return Some(def),
            Err(missed) if self.is_full(missed.severity()) => return None,
            Err(Missed::Ambiguous(names)) => Diagnostic::error(
                Code::AmbiguousKeyword,
                format!(
                    "{} is the beginning of several arguments of {}",
                    self.source.text(span),
                    statement.name
                ),
            )
            .help(format!("write one of {}", names.join(", "))),
            Err(Missed::Unknown(near)) => {
                let typed = self.source.text(span);
                let name = statement.name;
                let text = format!("{name} has no argument {typed}");
                if !near.is_empty() {
                    did_you_mean(Diagnostic::error(Code::UnknownArgument, text), span, &near)
                } else if statement.unchecked.is_empty() {
                    Diagnostic::error(Code::UnknownArgument, text)
                        .help(format!("`admire explain {name}` lists its arguments"))
                } else {
                    Diagnostic::note(
                        Code::UnknownArgument,
                        format!("{name} has no known argument {typed}; it is kept unchanged"),
                    )
                    .help("the list of its arguments may be incomplete: see `admire explain`")
                }
            }
        };
        self.complain(diagnostic, span, "");
        None
    }

    /// Returns true if the maximum number of diagnostics is reached; one diagnostic of this severity is then counted as dropped.
    fn is_full(&mut self, severity: Severity) -> bool {
        let full = self.diagnostics.len() >= MOST_OF_A_PARSER;
        if full {
            self.dropped = (self.dropped.0 + 1, self.dropped.1.max(severity));
        }
        full
    }

    /// Adds a diagnostic, located at `span`, unless a maximum number is reached.
    pub(super) fn complain(&mut self, diagnostic: Diagnostic, span: Span, label: &str) {
        self.complaints += 1;
        if self.complaints <= MOST_COMPLAINTS && !self.is_full(diagnostic.severity) {
            self.diagnostics
                .push(diagnostic.label(self.source.name(), span, label));
        }
    }
}

/// Cursor over the tokens of one statement. It skips trivia: blanks, comments and line ends.
pub(super) struct Cursor<'t> {
    tokens: &'t [Token],
    at: usize,
}

impl<'t> Cursor<'t> {
    fn new(tokens: &'t [Token]) -> Self {
        Self { tokens, at: 0 }
    }

    /// Returns the next significant token without consuming it.
    pub(crate) fn peek(&mut self) -> Option<Token> {
        while self
            .tokens
            .get(self.at)
            .is_some_and(|token| token.kind.is_trivia())
        {
            self.at += 1;
        }
        self.tokens.get(self.at).copied()
    }

    /// Consumes the token returned by [`peek`](Self::peek).
    pub(crate) fn advance(&mut self) {
        self.at += 1;
    }

    /// Consumes the punctuation mark if it is the next token; returns true if it was.
    pub(crate) fn take_mark(&mut self, mark: u8) -> bool {
        let there = self
            .peek()
            .is_some_and(|token| token.kind == TokenKind::Punctuation(mark));
        self.at += usize::from(there);
        there
    }

    /// Skips continuation marks.
    pub(crate) fn skip_continuation(&mut self) {
        while self
            .peek()
            .is_some_and(|token| token.kind == TokenKind::Continuation)
        {
            self.at += 1;
        }
    }

    /// Skips commas and continuation marks; returns true if there were any.
    pub(crate) fn skip_commas(&mut self) -> bool {
        let from = self.at;
        while self.peek().is_some_and(|token| {
            matches!(
                token.kind,
                TokenKind::Continuation | TokenKind::Punctuation(b',')
            )
        }) {
            self.at += 1;
        }
        self.at > from
    }

    /// Skips the separators between arguments: commas, continuation marks, backslashes, a second slash.
    fn skip_separators(&mut self) {
        while self.peek().is_some_and(|token| {
            matches!(
                token.kind,
                TokenKind::Continuation | TokenKind::Punctuation(b',' | b'\\' | b'/')
            )
        }) {
            self.at += 1;
        }
    }

    /// Skips an unreadable value, up to the next separator outside of parentheses. Returns the span of the value, which may be empty.
    pub(crate) fn skip_value(&mut self) -> Span {
        let mut span: Option<Span> = None;
        let mut depth = 0usize;
        while let Some(token) = self.peek() {
            match token.kind {
                TokenKind::Punctuation(b'(' | b'[') => depth += 1,
                TokenKind::Punctuation(b')' | b']') => depth = depth.saturating_sub(1),
                TokenKind::Continuation | TokenKind::Punctuation(b',' | b'\\') if depth == 0 => {
                    break;
                }
                _ => {}
            }
            span = Some(span.map_or(token.span, |before| before.join(token.span)));
            self.at += 1;
        }
        span.unwrap_or(Span::at(self.place(self.at)))
    }

    /// Returns the offset of the end of the last significant token before a cursor position.
    pub(crate) fn place(&self, position: usize) -> usize {
        self.tokens[..position.min(self.tokens.len())]
            .iter()
            .rfind(|token| !token.kind.is_trivia())
            .map_or(0, |token| token.span.end())
    }

    /// Returns the position of the cursor, which [`go_back`](Self::go_back) accepts.
    pub(crate) const fn position(&self) -> usize {
        self.at
    }

    /// Moves the cursor back to an earlier position.
    pub(crate) const fn go_back(&mut self, position: usize) {
        self.at = position;
    }

    /// Returns the tokens between an earlier position and the cursor.
    pub(crate) fn since(&self, position: usize) -> &'t [Token] {
        &self.tokens[position..self.at]
    }

    /// Returns the remaining tokens, including trivia.
    pub(crate) fn rest(&self) -> &'t [Token] {
        &self.tokens[self.at.min(self.tokens.len())..]
    }
}

/// Returns true if an equals sign follows the word, with only blanks in between.
fn is_assigned(source: &Source, word: Span) -> bool {
    let mut rest = source.bytes()[word.end()..].iter();
    rest.find(|byte| !matches!(byte, b' ' | b'\t')) == Some(&b'=')
}
