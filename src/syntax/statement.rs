use std::borrow::Cow;
use std::sync::Arc;

use super::{Expression, Number, Shared};
use crate::grammar::{ArgumentDef, Choice, StatementDef, ValueKind, find_choice};
use crate::text::{Source, Span};

/// One statement or command.
#[derive(Clone, PartialEq, Debug)]
pub struct Statement {
    /// Its definition, if the grammar knows it.
    pub def: Option<&'static StatementDef>,
    /// The keyword as typed.
    pub keyword: Span,
    /// Id and where it stands.
    pub id: Option<(u32, Span)>,
    /// From the keyword to the last byte that belongs to it; comments and line ends after it are not part of it.
    pub span: Span,
    /// Arguments in the order they are written.
    pub arguments: Shared<Argument>,
    /// The name in the `adams_view_name` comment before it.
    pub view_name: Option<Span>,
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

/// What stands after the equals sign of an argument.
#[derive(Clone, PartialEq, Debug)]
pub enum Value {
    /// Nothing: a flag.
    Flag,
    /// Numbers, integers or ids.
    Numbers(Shared<Number>),
    /// Words: one or several choices, with their spans.
    Words(Vec<Span>),
    /// One or several texts (quotes not included in the spans).
    Texts(Vec<Span>),
    /// A FUNCTION expression.
    Function(Arc<Expression>),
    /// `USER(...)`: the span of the whole call.
    User(Span),
    /// Something that does not fit the grammar; a diagnostic says why.
    Malformed(Span),
}

/// What a MARKER can be on, as its arguments name it.
pub(super) const OWNERS: [&str; 6] = [
    "PART",
    "POINT_MASS",
    "FLEX_BODY",
    "FE_PART",
    "CURVE",
    "SURFACE",
];

/// Why a marker without one of them cannot be added: where it would stand is not the person's choice.
pub(super) const NO_OWNER: &str = "does not say what it is on: PART=id, or another body";

impl Statement {
    /// The whole keyword in capitals, if the grammar knows the statement.
    pub fn kind(&self) -> Option<&'static str> {
        self.def.map(|def| def.name)
    }

    /// True for END, behind which nothing belongs to a dataset.
    pub(crate) fn is_end(&self, source: &Source) -> bool {
        source.slice(self.keyword).eq_ignore_ascii_case(b"END")
    }

    /// The id, if it has one.
    pub fn number(&self) -> Option<u32> {
        self.id.map(|(id, _)| id)
    }

    /// True for a body whose markers need not name it: those behind it, up to the next body, are on it (`state_marker`).
    pub fn carries_markers(&self) -> bool {
        matches!(self.kind(), Some("PART" | "POINT_MASS" | "FLEX_BODY"))
    }

    /// True for a MARKER that names nothing it is on: it is on the body defined before it.
    pub fn follows_body(&self) -> bool {
        self.kind() == Some("MARKER") && !OWNERS.iter().any(|owner| self.has(owner))
    }

    /// The last argument with this whole keyword (in capitals): what is written later counts.
    pub fn argument(&self, name: &str) -> Option<&Argument> {
        self.arguments
            .iter()
            .rev()
            .find(|argument| argument.def.is_some_and(|def| def.name == name))
    }

    /// The arguments with this keyword that count, in order: the last one, or all where each adds a row.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Argument> {
        let adds = self.def.is_some_and(|def| def.adds_rows(name));
        let last = self.argument(name);
        self.every(name)
            .filter(move |argument| adds || last.is_some_and(|last| std::ptr::eq(last, *argument)))
    }

    /// Every argument with this keyword, in order, whether it counts or not.
    pub(super) fn every<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Argument> {
        self.arguments
            .iter()
            .filter(move |argument| argument.def.is_some_and(|def| def.name == name))
    }

    /// True if the word stands among the arguments.
    pub fn has(&self, name: &str) -> bool {
        self.argument(name).is_some()
    }

    /// The numbers of an argument; empty if it is absent or holds none.
    pub fn numbers(&self, name: &str) -> &[Number] {
        self.argument(name).map_or(&[], Argument::numbers)
    }

    /// The first number of an argument.
    pub fn first(&self, name: &str) -> Option<f64> {
        self.numbers(name).first().map(|number| number.value)
    }

    /// The text of an argument, if it is there.
    pub fn text<'s>(&self, name: &str, source: &'s Source) -> Option<Cow<'s, str>> {
        self.argument(name)?.text(source)
    }
}

impl Argument {
    /// The whole keyword in capitals, if the grammar knows the argument.
    pub fn kind(&self) -> Option<&'static str> {
        self.def.map(|def| def.name)
    }

    /// Its numbers; empty if it holds none.
    pub fn numbers(&self) -> &[Number] {
        match &self.value {
            Value::Numbers(numbers) => numbers,
            _ => &[],
        }
    }

    /// Where the value stands: from its first to its last byte. An empty place after the keyword for flags.
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

    /// The texts or words it holds.
    pub fn texts<'s>(&self, source: &'s Source) -> Vec<Cow<'s, str>> {
        match &self.value {
            Value::Words(spans) | Value::Texts(spans) => {
                spans.iter().map(|span| source.text(*span)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// The first text or word; the text of a function.
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

    /// The choice words it holds, whole and in capitals; words the grammar does not know are left out.
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

/// A text over several lines as one line: line ends, `&` before them and commas after them become one blank.
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
