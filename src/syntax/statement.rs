use std::borrow::Cow;
use std::sync::Arc;

use super::{Expression, Number, Shared};
use crate::grammar::{ArgumentDef, Choice, StatementDef, ValueKind, find_choice};
use crate::text::{Source, Span};

/// One statement or command.
#[derive(Clone, PartialEq, Debug)]
pub struct Statement {
    /// Definition of the statement; `None` if it is not in the grammar.
    pub def: Option<&'static StatementDef>,
    /// Keyword as typed.
    pub keyword: Span,
    /// Id and its location.
    pub id: Option<(u32, Span)>,
    /// Span from the keyword to the last byte of the statement, without comments and line ends after it.
    pub span: Span,
    /// Arguments in the order they are written.
    pub arguments: Shared<Argument>,
    /// Name in the `adams_view_name` comment before the statement.
    pub view_name: Option<Span>,
}

/// One argument of a statement.
#[derive(Clone, PartialEq, Debug)]
pub struct Argument {
    /// Definition of the argument; `None` if it is not in the grammar.
    pub def: Option<&'static ArgumentDef>,
    /// Keyword as typed.
    pub name: Span,
    /// Span from the keyword to the end of the value.
    pub span: Span,
    /// The value.
    pub value: Value,
}

/// Value after the equals sign of an argument.
#[derive(Clone, PartialEq, Debug)]
pub enum Value {
    /// No value: the argument is a flag.
    Flag,
    /// Numbers, integers or ids.
    Numbers(Shared<Number>),
    /// One or several choices, as spans of their words.
    Words(Vec<Span>),
    /// One or several texts, as spans without quotes.
    Texts(Vec<Span>),
    /// A FUNCTION expression.
    Function(Arc<Expression>),
    /// `USER(...)`: the span of the whole call.
    User(Span),
    /// A value that does not fit the grammar; a diagnostic gives the reason.
    Malformed(Span),
}

/// Arguments with which a MARKER can name its body or geometry.
pub(super) const OWNERS: [&str; 6] = [
    "PART",
    "POINT_MASS",
    "FLEX_BODY",
    "FE_PART",
    "CURVE",
    "SURFACE",
];

/// Reason why a marker without any of [`OWNERS`] cannot be added: the preceding body would own it by accident.
pub(super) const NO_OWNER: &str = "does not say what it is on: PART=id, or another body";

impl Statement {
    /// Returns the full keyword in capitals; `None` if the statement is not in the grammar.
    pub fn kind(&self) -> Option<&'static str> {
        self.def.map(|def| def.name)
    }

    /// Returns true for END, after which nothing belongs to the dataset.
    pub(crate) fn is_end(&self, source: &Source) -> bool {
        source.slice(self.keyword).eq_ignore_ascii_case(b"END")
    }

    /// Returns the id, if the statement has one.
    pub fn number(&self) -> Option<u32> {
        self.id.map(|(id, _)| id)
    }

    /// Returns true for a body that owns the markers after it, up to the next body, if they name none (`state_marker`).
    pub fn carries_markers(&self) -> bool {
        matches!(self.kind(), Some("PART" | "POINT_MASS" | "FLEX_BODY"))
    }

    /// Returns true for a MARKER that names no owner; it belongs to the preceding body.
    pub fn follows_body(&self) -> bool {
        self.kind() == Some("MARKER") && !OWNERS.iter().any(|owner| self.has(owner))
    }

    /// Returns the last argument with this full keyword (in capitals), which is the one that counts.
    pub fn argument(&self, name: &str) -> Option<&Argument> {
        self.arguments
            .iter()
            .rev()
            .find(|argument| argument.def.is_some_and(|def| def.name == name))
    }

    /// Iterates over the arguments with this keyword that count: the last one, or all of them if each adds a row.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Argument> {
        let adds = self.def.is_some_and(|def| def.adds_rows(name));
        let last = self.argument(name);
        self.every(name)
            .filter(move |argument| adds || last.is_some_and(|last| std::ptr::eq(last, *argument)))
    }

    /// Iterates over all arguments with this keyword in order, whether they count or not.
    pub(super) fn every<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Argument> {
        self.arguments
            .iter()
            .filter(move |argument| argument.def.is_some_and(|def| def.name == name))
    }

    /// Returns true if the statement has an argument with this keyword.
    pub fn has(&self, name: &str) -> bool {
        self.argument(name).is_some()
    }

    /// Returns the numbers of an argument; empty if it is absent or has no numbers.
    pub fn numbers(&self, name: &str) -> &[Number] {
        self.argument(name).map_or(&[], Argument::numbers)
    }

    /// Returns the first number of an argument.
    pub fn first(&self, name: &str) -> Option<f64> {
        self.numbers(name).first().map(|number| number.value)
    }

    /// Returns the text of an argument, if it is present.
    pub fn text<'s>(&self, name: &str, source: &'s Source) -> Option<Cow<'s, str>> {
        self.argument(name)?.text(source)
    }
}

impl Argument {
    /// Returns the full keyword in capitals; `None` if the argument is not in the grammar.
    pub fn kind(&self) -> Option<&'static str> {
        self.def.map(|def| def.name)
    }

    /// Returns the numbers of the argument; empty if it has none.
    pub fn numbers(&self) -> &[Number] {
        match &self.value {
            Value::Numbers(numbers) => numbers,
            _ => &[],
        }
    }

    /// Returns the span of the value from its first to its last byte; for a flag, an empty span after the keyword.
    pub fn value_span(&self) -> Span {
        let several = |spans: &[Span]| match (spans.first(), spans.last()) {
            (Some(first), Some(last)) => first.join(*last),
            _ => Span::at(self.span.end()),
        };
        match &self.value {
            Value::Flag => Span::at(self.name.end()),
            Value::Numbers(numbers) => match (numbers.first(), numbers.last()) {
                (Some(first), Some(last)) => first.span.join(last.span),
                _ => Span::at(self.span.end()),
            },
            Value::Words(spans) | Value::Texts(spans) => several(spans),
            Value::Function(expression) => expression.span,
            Value::User(span) | Value::Malformed(span) => *span,
        }
    }

    /// Returns the texts or words of the argument.
    pub fn texts<'s>(&self, source: &'s Source) -> Vec<Cow<'s, str>> {
        match &self.value {
            Value::Words(spans) | Value::Texts(spans) => {
                spans.iter().map(|span| source.text(*span)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Returns the first text or word, or the text of a function.
    pub fn text<'s>(&self, source: &'s Source) -> Option<Cow<'s, str>> {
        match &self.value {
            Value::Words(spans) | Value::Texts(spans) => {
                spans.first().map(|span| source.text(*span))
            }
            Value::Function(expression) => Some(Cow::Owned(expression.text.clone())),
            Value::User(span) => Some(Cow::Owned(without_continuation(&source.text(*span)))),
            Value::Flag | Value::Numbers(_) | Value::Malformed(_) => None,
        }
    }

    /// Returns the choices of the argument as full words in capitals; unknown words are left out.
    pub fn choices(&self, source: &Source) -> Vec<&'static str> {
        let (Value::Words(spans), Some(known)) = (&self.value, self.choice_table()) else {
            return Vec::new();
        };
        spans
            .iter()
            .filter_map(|span| find_choice(known, source.slice(*span)).found())
            .map(|choice| choice.name)
            .collect()
    }

    fn choice_table(&self) -> Option<&'static [Choice]> {
        match self.def?.kind {
            ValueKind::Choice(choices) => Some(choices),
            _ => None,
        }
    }
}

/// Joins a text of several lines into one line. Each line end becomes a blank, with a `&` before it and a comma after it; comment lines are
/// dropped.
pub(super) fn without_continuation(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for line in text.split(['\n', '\r']) {
        let line = line.trim();
        if line.is_empty() || line.starts_with('!') {
            continue;
        }
        let line = if out.is_empty() {
            line
        } else {
            out.push(' ');
            line.strip_prefix(',').unwrap_or(line).trim_start()
        };
        out.push_str(line.strip_suffix('&').unwrap_or(line).trim_end());
    }
    out
}
