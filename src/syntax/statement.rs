use std::borrow::Cow;
use std::sync::Arc;

use super::{Expression, Number, Shared};
use crate::grammar::{ArgumentDef, Choice, StatementDef, ValueKind, find_choice};
use crate::text::{Source, Span};

/// One statement of a dataset, or one command of a command file.
#[derive(Clone, PartialEq, Debug)]
pub struct Statement {
    /// Definition of the statement; `None` if it is not in the grammar.
    pub def: Option<&'static StatementDef>,
    /// Span of the keyword as typed.
    pub keyword: Span,
    /// Id of the statement and the span of the id; `None` if no id is written.
    pub id: Option<(u32, Span)>,
    /// Span from the keyword to the last byte of the statement. Comments and line ends after the statement are not included.
    pub span: Span,
    /// Arguments in the order they are written.
    pub arguments: Shared<Argument>,
    /// Span of the name in the `adams_view_name` comment before the statement.
    pub view_name: Option<Span>,
}

/// One argument of a statement.
#[derive(Clone, PartialEq, Debug)]
pub struct Argument {
    /// Definition of the argument; `None` if it is not in the grammar.
    pub def: Option<&'static ArgumentDef>,
    /// Span of the keyword as typed.
    pub name: Span,
    /// Span from the keyword to the end of the value.
    pub span: Span,
    /// Value after the equals sign.
    pub value: Value,
}

/// Value of an argument.
#[derive(Clone, PartialEq, Debug)]
pub enum Value {
    /// No value: the argument consists of its keyword.
    Flag,
    /// Numbers, integers or ids.
    Numbers(Shared<Number>),
    /// One or several words that the argument allows, as spans.
    Words(Vec<Span>),
    /// One or several texts, as spans that exclude the quotes.
    Texts(Vec<Span>),
    /// A FUNCTION expression.
    Function(Arc<Expression>),
    /// A call `USER(...)` of a user subroutine; the span covers the whole call.
    User(Span),
    /// A value that does not fit the grammar; a diagnostic gives the reason.
    Malformed(Span),
}

/// Arguments by which a MARKER names the body or geometry it is on.
pub(super) const OWNERS: [&str; 6] = [
    "PART",
    "POINT_MASS",
    "FLEX_BODY",
    "FE_PART",
    "CURVE",
    "SURFACE",
];

/// End of the error message for a new marker without any of [`OWNERS`]. Such a marker would belong to whatever body precedes it.
pub(super) const NO_OWNER: &str =
    "does not name its body: add PART=id (or POINT_MASS, FLEX_BODY, FE_PART, CURVE, SURFACE)";

impl Statement {
    /// Returns the full keyword in capitals; `None` if the statement is not in the grammar.
    pub fn kind(&self) -> Option<&'static str> {
        self.def.map(|def| def.name)
    }

    /// Returns true for an END statement; nothing after it belongs to the dataset.
    pub(crate) fn is_end(&self, source: &Source) -> bool {
        source.slice(self.keyword).eq_ignore_ascii_case(b"END")
    }

    /// Returns the id, if the statement has one.
    pub fn number(&self) -> Option<u32> {
        self.id.map(|(id, _)| id)
    }

    /// Returns true for a body to which markers may belong without naming it: markers that follow it and name no body (`state_marker`).
    pub fn carries_markers(&self) -> bool {
        matches!(self.kind(), Some("PART" | "POINT_MASS" | "FLEX_BODY"))
    }

    /// Returns true for a MARKER that names no body or geometry; it belongs to the preceding body.
    pub fn follows_body(&self) -> bool {
        self.kind() == Some("MARKER") && !OWNERS.iter().any(|owner| self.has(owner))
    }

    /// Returns the last argument with this full keyword (in capitals). If an argument is repeated, its last occurrence counts.
    pub fn argument(&self, name: &str) -> Option<&Argument> {
        self.arguments
            .iter()
            .rev()
            .find(|argument| argument.def.is_some_and(|def| def.name == name))
    }

    /// Iterates over the arguments with this full keyword that count: only the last occurrence, or all occurrences if each of them adds a
    /// row.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Argument> {
        let adds = self.def.is_some_and(|def| def.adds_rows(name));
        let last = self.argument(name);
        self.every(name)
            .filter(move |argument| adds || last.is_some_and(|last| std::ptr::eq(last, *argument)))
    }

    /// Iterates over all arguments with this full keyword, in order, including occurrences that do not count.
    pub(super) fn every<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Argument> {
        self.arguments
            .iter()
            .filter(move |argument| argument.def.is_some_and(|def| def.name == name))
    }

    /// Returns true if the statement has an argument with this full keyword.
    pub fn has(&self, name: &str) -> bool {
        self.argument(name).is_some()
    }

    /// Returns the numbers of the argument with this full keyword; empty if the argument is absent or has no numbers.
    pub fn numbers(&self, name: &str) -> &[Number] {
        self.argument(name).map_or(&[], Argument::numbers)
    }

    /// Returns the first number of the argument with this full keyword, if there is one.
    pub fn first(&self, name: &str) -> Option<f64> {
        self.numbers(name).first().map(|number| number.value)
    }

    /// Returns the text of the argument with this full keyword, if the argument is present and has a text.
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

    /// Returns the first text or word of the argument, or the text of its function.
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

    /// Returns the words of the argument, spelled out and in capitals; words that the grammar does not contain are left out.
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

/// Joins a text of several lines into one line.
///
/// Each line end becomes a blank, together with a `&` before it and a comma after it. Comment lines are dropped.
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
