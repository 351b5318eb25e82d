//! Differences between two datasets, object by object and independent of layout.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::lexer::Lexer;
use super::number::parse_number;
use super::{Address, Argument, Dataset, Expression, Number, Statement, TokenKind, Value};
use crate::text::{Source, Span};

/// Tolerance for comparing numbers: a and b count as equal if |a - b| <= absolute + relative max(|a|, |b|).
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct DiffTolerance {
    /// Absolute tolerance, in the unit of the compared numbers.
    pub absolute: f64,
    /// Relative tolerance, as a fraction of the larger of the two magnitudes.
    pub relative: f64,
}

/// One difference between two versions of an object.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Difference {
    /// Address of the object or value that differs: `BUSHING/12.K.2`.
    pub address: String,
    /// ADAMS/View name of the object, if it has one.
    pub name: Option<String>,
    /// Kind of the difference, with both values.
    pub change: DiffKind,
}

/// Kind of a difference between two datasets.
#[derive(Clone, PartialEq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DiffKind {
    /// The object is only in the second dataset.
    Added,
    /// The object is only in the first dataset.
    Removed,
    /// A number differs by more than the tolerance.
    Number {
        /// Value in the first dataset; angles in radians.
        before: f64,
        /// Value in the second dataset; angles in radians.
        after: f64,
        /// Spellings in the first and in the second dataset; a default that is not written is formatted from its value.
        written: [String; 2],
    },
    /// Something other than a number differs: a text, a function, a word, or the number of values.
    Text {
        /// Text in the first dataset; `None` if the argument is not written.
        before: Option<String>,
        /// Text in the second dataset; `None` if the argument is not written.
        after: Option<String>,
    },
}

impl DiffTolerance {
    /// Returns true if two numbers count as equal.
    pub fn same(self, a: f64, b: f64) -> bool {
        a == b || (a - b).abs() <= self.absolute + self.relative * a.abs().max(b.abs())
    }
}

/// Returns the differences between two datasets. The differences of the objects in `before` come first, in the order of these objects.
/// Objects that only `after` contains follow.
///
/// Comments, line breaks, the order of arguments, the spelling of numbers, and whether a default is written out make no difference.
pub fn diff(before: &Dataset, after: &Dataset, tolerance: DiffTolerance) -> Vec<Difference> {
    let mut found = Vec::new();
    if before.title() != after.title() {
        found.push(Difference {
            address: "TITLE".into(),
            name: None,
            change: DiffKind::Text {
                before: Some(before.title().into_owned()),
                after: Some(after.title().into_owned()),
            },
        });
    }
    let (old, new) = (objects(before), objects(after));
    let others: BTreeMap<&str, &Statement> = new
        .iter()
        .map(|(key, statement)| (key.as_str(), *statement))
        .collect();
    let known: BTreeSet<&str> = old.iter().map(|(key, _)| key.as_str()).collect();
    for (key, statement) in &old {
        match others.get(key.as_str()) {
            Some(other) => {
                let pair = Pair {
                    before: (before, statement),
                    after: (after, other),
                    key,
                    tolerance,
                };
                pair.compare(&mut found);
            }
            None => found.push(whole(key, before, statement, DiffKind::Removed)),
        }
    }
    for (key, statement) in &new {
        if !known.contains(key.as_str()) {
            found.push(whole(key, after, statement, DiffKind::Added));
        }
    }
    found
}

/// Returns all statements, each with a key that identifies its object.
///
/// The key is the address of the object, or the whole text of a statement that is not in the grammar. If a key is repeated, a number is
/// appended to it.
fn objects(dataset: &Dataset) -> Vec<(String, &Statement)> {
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let mut all = Vec::new();
    for statement in dataset.statements() {
        let mut key = match Address::of(statement) {
            Some(address) => address.to_string(),
            None => one_line(dataset.source(), statement.span),
        };
        let times = seen.entry(key.clone()).or_insert(0);
        *times += 1;
        if *times > 1 {
            key = format!("{key} ({times})");
        }
        all.push((key, statement));
    }
    all
}

fn whole(key: &str, dataset: &Dataset, statement: &Statement, change: DiffKind) -> Difference {
    Difference {
        address: key.to_string(),
        name: view_name(dataset, statement),
        change,
    }
}

fn view_name(dataset: &Dataset, statement: &Statement) -> Option<String> {
    Some(dataset.source().text(statement.view_name?).into_owned())
}

/// The versions of one object in the two datasets.
struct Pair<'a> {
    before: (&'a Dataset, &'a Statement),
    after: (&'a Dataset, &'a Statement),
    key: &'a str,
    tolerance: DiffTolerance,
}

impl Pair<'_> {
    fn compare(&self, found: &mut Vec<Difference>) {
        let names = (
            view_name(self.before.0, self.before.1),
            view_name(self.after.0, self.after.1),
        );
        if names.0 != names.1 {
            self.push(
                found,
                "",
                DiffKind::Text {
                    before: names.0,
                    after: names.1,
                },
            );
        }
        let mut seen = BTreeSet::new();
        let arguments = self
            .before
            .1
            .arguments
            .iter()
            .chain(&self.after.1.arguments);
        for def in arguments.filter_map(|argument| argument.def) {
            if seen.insert(def.name) {
                self.argument(def.name, def.default, found);
            }
        }
    }

    fn argument(&self, name: &str, default: &[f64], found: &mut Vec<Difference>) {
        let (old, new) = (self.before.1.argument(name), self.after.1.argument(name));
        if let (Some(Value::Function(old)), Some(Value::Function(new))) =
            (old.map(|a| &a.value), new.map(|a| &a.value))
        {
            if self.same_function(old, new) {
                return;
            }
        } else if let (Some(Value::User(_)), Some(Value::User(_))) =
            (old.map(|a| &a.value), new.map(|a| &a.value))
        {
            let text = |argument: Option<&Argument>, dataset: &Dataset| {
                argument
                    .and_then(|argument| argument.text(dataset.source()))
                    .unwrap_or_default()
                    .into_owned()
            };
            if self.same_call(&text(old, self.before.0), &text(new, self.after.0)) {
                return;
            }
        } else if let (Some(old), Some(new)) = (
            Self::numbers(self.before.1, name, default),
            Self::numbers(self.after.1, name, default),
        ) && (old.len() == new.len())
        {
            for (k, (old, new)) in old.iter().zip(&new).enumerate() {
                if !self.tolerance.same(old.value, new.value) {
                    let change = DiffKind::Number {
                        before: old.value,
                        after: new.value,
                        written: [written(self.before.0, old), written(self.after.0, new)],
                    };
                    self.push(found, &format!(".{name}.{}", k + 1), change);
                }
            }
            return;
        }
        let shown = |(dataset, statement): (&Dataset, &Statement)| {
            let texts: Vec<String> = statement
                .all(name)
                .map(|argument| text(dataset.source(), argument))
                .collect();
            (!texts.is_empty()).then(|| texts.join(" | "))
        };
        let (old, new) = (shown(self.before), shown(self.after));
        if old != new {
            self.push(
                found,
                &format!(".{name}"),
                DiffKind::Text {
                    before: old,
                    after: new,
                },
            );
        }
    }

    /// Returns the values of an argument, or its default values if the argument is not written. Returns `None` if there are no values, or
    /// if a value is not a number.
    fn numbers(statement: &Statement, name: &str, default: &[f64]) -> Option<Vec<Number>> {
        let mut arguments = statement.all(name).peekable();
        if arguments.peek().is_none() {
            let unwritten = |value: &f64| Number {
                value: *value,
                degrees: false,
                span: Span::default(),
            };
            return (!default.is_empty()).then(|| default.iter().map(unwritten).collect());
        }
        let mut values = Vec::new();
        for argument in arguments {
            match &argument.value {
                Value::Numbers(numbers) => values.extend_from_slice(numbers),
                _ => return None,
            }
        }
        Some(values)
    }

    fn same_function(&self, old: &Expression, new: &Expression) -> bool {
        shape(&old.text) == shape(&new.text)
            && old.literals.len() == new.literals.len()
            && old
                .literals
                .iter()
                .zip(&new.literals)
                .all(|(a, b)| self.tolerance.same(a.value, b.value))
    }

    /// Returns true if two calls of user subroutines are equal apart from layout and from numbers that differ within the tolerance.
    fn same_call(&self, old: &str, new: &str) -> bool {
        let numbers = |text: &str| -> Vec<f64> {
            Lexer::new(text.as_bytes(), Span::new(0, text.len()), false)
                .filter(|token| token.kind == TokenKind::Number)
                .filter_map(|token| Some(parse_number(&text.as_bytes()[token.span.range()])?.0))
                .collect()
        };
        let (a, b) = (numbers(old), numbers(new));
        shape(old) == shape(new)
            && a.len() == b.len()
            && a.iter().zip(&b).all(|(a, b)| self.tolerance.same(*a, *b))
    }

    fn push(&self, found: &mut Vec<Difference>, place: &str, change: DiffKind) {
        found.push(Difference {
            address: format!("{}{place}", self.key),
            name: view_name(self.after.0, self.after.1),
            change,
        });
    }
}

/// Returns the spelling of a number in the file, or its formatted value if the number is not written.
fn written(dataset: &Dataset, number: &Number) -> String {
    if number.span.is_empty() {
        return number.value.to_string();
    }
    dataset.source().text(number.span).into_owned()
}

/// Returns the text of a function in capitals, without blanks and with a placeholder for each number.
///
/// The result is bytes because a token may end inside a multi-byte character.
fn shape(text: &str) -> Vec<u8> {
    let mut shape = Vec::with_capacity(text.len());
    for token in Lexer::new(text.as_bytes(), Span::new(0, text.len()), false) {
        match token.kind {
            TokenKind::Blank => {}
            TokenKind::Number => shape.push(b'#'),
            _ => {
                shape.extend(text.as_bytes()[token.span.range()].to_ascii_uppercase());
            }
        }
    }
    shape
}

/// Formats the value of an argument in one line; words are written in full and in capitals.
fn text(source: &Source, argument: &Argument) -> String {
    match &argument.value {
        Value::Flag => String::new(),
        Value::Words(_) => argument.choices(source).join(":"),
        Value::Texts(_) => argument.texts(source).join(":"),
        Value::Function(expression) => expression.text.clone(),
        Value::Numbers(numbers) => {
            let spelled = numbers.iter().map(|number| source.text(number.span));
            spelled.collect::<Vec<_>>().join(", ")
        }
        Value::User(_) => argument.text(source).unwrap_or_default().into_owned(),
        Value::Malformed(span) => one_line(source, *span),
    }
}

/// Returns a part of a file with each run of blanks and line ends replaced by one blank.
fn one_line(source: &Source, span: Span) -> String {
    source
        .text(span)
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}
