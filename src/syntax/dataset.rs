use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use super::lexer::Lexer;
use super::lines::{logical_lines, physical_line};
use super::statements::{BOM, one, parse_lines, starts_line};
use super::{CommandFile, Statement, Token, TokenKind};
use crate::diagnostic::{Checked, Code, Diagnostic};
use crate::grammar::Role;
use crate::text::{Edit, EditConflict, Source, Span, apply_edits};

/// An ADAMS/Solver dataset (.adm). All of its bytes are kept, together with the positions of its statements. Cloning is cheap.
#[derive(Clone, Debug)]
pub struct Dataset {
    source: Source,
    /// The first line, without its line end.
    title: Span,
    statements: Arc<Vec<Statement>>,
    /// The bytes after END.
    after_end: Span,
    index: Arc<Index>,
}

/// Lookup tables of statements, built on first use because a large deck has millions of statements.
#[derive(Debug, Default)]
struct Index {
    /// Pairs (id, statement index) for each kind of statement, in increasing order of id. If statements share an id, only the first is
    /// listed.
    by_id: OnceLock<HashMap<&'static str, Vec<(u32, u32)>>>,
    /// Statement indices for each view name; the names are in lower case.
    by_name: OnceLock<HashMap<String, Vec<usize>>>,
}

impl Dataset {
    /// Reads a dataset from any bytes.
    ///
    /// Diagnostics report unknown, ambiguous and malformed keywords, unreadable values, and a missing END.
    pub fn parse(source: Source) -> Checked<Self> {
        let bytes = source.bytes();
        let title = physical_line(bytes, 0);
        let (lines, end) = logical_lines(bytes, title.next, true);
        let (mut statements, mut diagnostics) = parse_lines(&source, &lines, Role::Dataset);
        let is_end = |statement: &Statement| statement.is_end(&source);
        let mut after_end = Span::at(bytes.len());
        if let Some(last) = statements.iter().position(is_end) {
            statements.truncate(last + 1);
            let start = statements[last].span.end();
            after_end = Span::new(start, bytes.len());
            // Statements after END on the same line were parsed too, but they are not part of the dataset.
            if end.is_none_or(|end| end > start) {
                diagnostics.retain(|diagnostic| {
                    diagnostic
                        .labels
                        .first()
                        .is_none_or(|label| label.span.start() < start)
                });
            }
        } else {
            diagnostics.push(missing_end(source.name(), bytes.len()));
        }
        Checked {
            value: Self {
                title: title.span,
                statements: Arc::new(statements),
                after_end,
                index: Arc::default(),
                source,
            },
            diagnostics,
        }
    }

    /// Wraps the commands of a file as the statements of a dataset, for rules that check each statement separately.
    pub(super) fn of_commands(file: &CommandFile) -> Self {
        Self {
            source: file.source().clone(),
            title: Span::at(0),
            statements: Arc::new(file.commands().to_vec()),
            after_end: Span::at(file.bytes().len()),
            index: Arc::default(),
        }
    }

    /// Wraps one command of a file as the only statement of a dataset, so that code for reading and editing statements also works on
    /// commands.
    pub fn of_command(file: &CommandFile, at: usize) -> Self {
        Self {
            statements: Arc::new(file.commands().get(at).cloned().into_iter().collect()),
            ..Self::of_commands(file)
        }
    }

    /// Returns the source file.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// Returns all bytes of the file, exactly as they were read.
    pub fn bytes(&self) -> &[u8] {
        self.source.bytes()
    }

    /// Returns the title: the first line, without surrounding blanks.
    pub fn title(&self) -> Cow<'_, str> {
        let line = self.source.slice(self.title);
        let bom = if line.starts_with(BOM) { BOM.len() } else { 0 };
        let text = self
            .source
            .text(Span::new(self.title.start() + bom, self.title.end()));
        match text {
            Cow::Borrowed(text) => Cow::Borrowed(text.trim()),
            Cow::Owned(text) => Cow::Owned(text.trim().to_string()),
        }
    }

    /// Returns the span of the title, which is the first line without its line end.
    pub fn title_span(&self) -> Span {
        self.title
    }

    /// Returns all statements in order of appearance, including END.
    pub fn statements(&self) -> &[Statement] {
        &self.statements
    }

    /// Iterates over all tokens of the file; together they cover every byte.
    pub fn tokens(&self) -> impl Iterator<Item = Token> + '_ {
        let body = Span::new(self.title.end(), self.after_end.start());
        one(TokenKind::Title, self.title)
            .chain(Lexer::new(self.bytes(), body, false))
            .chain(one(TokenKind::AfterEnd, self.after_end))
    }

    /// Iterates over the tokens of one statement, including the blanks, comments and line ends between them.
    pub fn statement_tokens(&self, statement: &Statement) -> impl Iterator<Item = Token> + '_ {
        Lexer::new(
            self.bytes(),
            statement.span,
            starts_line(self.bytes(), statement.span.start()),
        )
    }

    /// Returns the first statement of this kind (full keyword in capitals) with this id.
    pub fn statement(&self, kind: &str, id: Option<u32>) -> Option<&Statement> {
        self.position(kind, id).map(|at| &self.statements[at])
    }

    /// Returns the index of the first statement of this kind with this id. Without an id, any statement of the kind matches.
    pub fn position(&self, kind: &str, id: Option<u32>) -> Option<usize> {
        match id {
            None => self
                .statements
                .iter()
                .position(|statement| statement.kind() == Some(kind)),
            Some(id) => {
                let def = crate::grammar::STATEMENTS
                    .iter()
                    .find(|def| def.name == kind)?;
                let of_kind = self.ids().get(def.name)?;
                let at = of_kind.binary_search_by_key(&id, |(id, _)| *id).ok()?;
                Some(of_kind[at].1 as usize)
            }
        }
    }

    /// Returns the indices of the statements that have this view name; case is ignored.
    pub(crate) fn named(&self, name: &str) -> &[usize] {
        self.names()
            .get(&name.to_lowercase())
            .map_or(&[], Vec::as_slice)
    }

    /// Iterates over all statements that have a view name, as pairs of name and statement in order of appearance.
    pub(crate) fn view_names(&self) -> impl Iterator<Item = (Cow<'_, str>, &Statement)> {
        self.statements
            .iter()
            .filter_map(|statement| Some((self.source.text(statement.view_name?), statement)))
    }

    /// Returns the view name of a statement, or its kind and id (`PART_2`) if it has no view name.
    pub fn name<'s>(&'s self, statement: &Statement) -> Cow<'s, str> {
        if let Some(span) = statement.view_name {
            return self.source.text(span);
        }
        let kind = statement.kind().map_or_else(
            || self.source.text(statement.keyword).to_ascii_uppercase(),
            str::to_string,
        );
        Cow::Owned(match statement.id {
            Some((id, _)) => format!("{kind}_{id}"),
            None => kind,
        })
    }

    /// Applies edits to the text and parses the edited text as a new dataset.
    ///
    /// # Errors
    /// Returns an error if two edits overlap or an edit lies outside of the file.
    pub fn edited(&self, edits: &[Edit]) -> Result<Checked<Self>, EditConflict> {
        Ok(Self::parse(self.text_after(edits)?))
    }

    /// Applies edits and returns the edited text without parsing it.
    ///
    /// # Errors
    /// Returns an error if two edits overlap or an edit lies outside of the file.
    pub fn text_after(&self, edits: &[Edit]) -> Result<Source, EditConflict> {
        let bytes = apply_edits(self.bytes(), edits)?;
        Ok(Source::new(self.source.name(), bytes))
    }

    /// Replaces the content of this dataset by a new text, parses that text, and returns the diagnostics of [`parse`](Self::parse).
    ///
    /// The old statements are released before the new text is parsed, because the statements of a large deck take several times the memory
    /// of its text.
    pub fn reread(&mut self, text: Source) -> Vec<Diagnostic> {
        self.statements = Arc::default();
        self.index = Arc::default();
        let read = Self::parse(text);
        *self = read.value;
        read.diagnostics
    }

    fn ids(&self) -> &HashMap<&'static str, Vec<(u32, u32)>> {
        self.index.by_id.get_or_init(|| {
            let mut by_id: HashMap<&'static str, Vec<(u32, u32)>> = HashMap::new();
            for (at, statement) in self.statements.iter().enumerate() {
                if let (Some(kind), Some(id)) = (statement.kind(), statement.number()) {
                    // Every statement has at least one byte, and byte offsets have 32 bits, so the index fits.
                    by_id.entry(kind).or_default().push((id, at as u32));
                }
            }
            for of_kind in by_id.values_mut() {
                of_kind.sort_by_key(|(id, _)| *id);
                of_kind.dedup_by_key(|(id, _)| *id);
            }
            by_id
        })
    }

    fn names(&self) -> &HashMap<String, Vec<usize>> {
        self.index.by_name.get_or_init(|| {
            let mut by_name: HashMap<String, Vec<usize>> = HashMap::new();
            for (at, statement) in self.statements.iter().enumerate() {
                if let Some(name) = statement.view_name {
                    let name = self.source.text(name).to_lowercase();
                    by_name.entry(name).or_default().push(at);
                }
            }
            by_name
        })
    }
}

/// Returns the warning for a dataset without END; `size` is its length in bytes.
pub fn missing_end(file: &str, size: usize) -> Diagnostic {
    Diagnostic::warning(Code::MissingEnd, "the dataset has no END statement")
        .label(file, Span::at(size), "END belongs here")
        .help("the FORTRAN solver refuses a dataset without END")
}
