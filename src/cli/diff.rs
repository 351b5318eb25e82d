use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use serde_json::json;

use crate::syntax::{Argument, Dataset, Statement, Value};

use super::Outcome;
use super::shell::{Exit, Format, Shell};

/// Say what changed between two datasets, object by object.
///
/// Layout, order, comments and the spelling of keywords and numbers do not matter. Exit code 1 if anything changed.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// The dataset before.
    a: PathBuf,
    /// The dataset after.
    b: PathBuf,
    /// Numbers that differ by at most this fraction are the same.
    #[arg(long, default_value_t = 0.0)]
    rel: f64,
    /// Numbers that differ by at most this are the same.
    #[arg(long, default_value_t = 0.0)]
    abs: f64,
}

/// Prints a line per change.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let (a, b) = (shell.read(&arguments.a)?, shell.read(&arguments.b)?);
    let (a, b) = (Dataset::parse(a).value, Dataset::parse(b).value);
    let changes = changes(&a, &b, |x, y| {
        x == y || (x - y).abs() <= arguments.abs + arguments.rel * x.abs().max(y.abs())
    });
    let text = match shell.format {
        Format::Json => {
            let all: Vec<_> = changes
                .iter()
                .map(|c| json!({ "address": c.address, "before": c.before, "after": c.after }))
                .collect();
            serde_json::to_string_pretty(&all).expect("JSON values print") + "\n"
        }
        Format::Text | Format::Plain => changes.iter().map(Change::line).collect(),
    };
    shell.print(&text);
    Ok(if changes.is_empty() {
        Exit::Fine
    } else {
        Exit::Findings
    })
}

/// What is said of one object or one argument before and after; absent where it is not there.
#[derive(Debug, PartialEq)]
struct Change {
    address: String,
    before: Option<String>,
    after: Option<String>,
}

impl Change {
    fn line(&self) -> String {
        match (&self.before, &self.after) {
            (Some(before), Some(after)) => format!("{}: {before} -> {after}\n", self.address),
            (Some(before), None) => format!("- {} {before}\n", self.address),
            (None, Some(after)) => format!("+ {} {after}\n", self.address),
            (None, None) => String::new(),
        }
    }
}

/// A statement's place in the order of a person: kind, id, and which of several of the same.
type Key = (String, Option<u32>, usize);

fn objects(dataset: &Dataset) -> BTreeMap<Key, &Statement> {
    let mut all = BTreeMap::new();
    for statement in dataset.statements() {
        let kind = kind(dataset, statement);
        let mut key = (kind, statement.number(), 0);
        while all.contains_key(&key) {
            key.2 += 1;
        }
        all.insert(key, statement);
    }
    all
}

fn kind(dataset: &Dataset, statement: &Statement) -> String {
    statement.kind().map_or_else(
        || {
            let typed = dataset.source().text(statement.keyword);
            typed.to_ascii_uppercase()
        },
        str::to_string,
    )
}

fn changes(a: &Dataset, b: &Dataset, same: impl Fn(f64, f64) -> bool) -> Vec<Change> {
    let mut out = Vec::new();
    if a.title() != b.title() {
        out.push(Change {
            address: "TITLE".to_string(),
            before: Some(a.title().into_owned()),
            after: Some(b.title().into_owned()),
        });
    }
    let (in_a, in_b) = (objects(a), objects(b));
    let keys: BTreeSet<&Key> = in_a.keys().chain(in_b.keys()).collect();
    for key in keys {
        let address = match key.1 {
            Some(id) => format!("{}/{id}", key.0),
            None => key.0.clone(),
        };
        let name = |dataset: &Dataset, statement: &Statement| {
            statement
                .view_name
                .map_or_else(String::new, |span| dataset.source().text(span).into_owned())
        };
        match (in_a.get(key), in_b.get(key)) {
            (Some(before), Some(after)) => {
                let (old, new) = (name(a, before), name(b, after));
                if old != new {
                    out.push(Change {
                        address: format!("{address} name"),
                        before: Some(old),
                        after: Some(new),
                    });
                }
                in_statement(&address, (a, before), (b, after), &same, &mut out);
            }
            (before, after) => out.push(Change {
                before: before.map(|statement| name(a, statement)),
                after: after.map(|statement| name(b, statement)),
                address,
            }),
        }
    }
    out
}

fn in_statement(
    address: &str,
    (a, before): (&Dataset, &Statement),
    (b, after): (&Dataset, &Statement),
    same: &impl Fn(f64, f64) -> bool,
    out: &mut Vec<Change>,
) {
    let arguments = |dataset: &Dataset, statement: &Statement| {
        let mut all: BTreeMap<(String, usize), Shown> = BTreeMap::new();
        for argument in &statement.arguments {
            let name = argument.kind().map_or_else(
                || dataset.source().text(argument.name).to_ascii_uppercase(),
                str::to_string,
            );
            let mut key = (name, 0);
            while all.contains_key(&key) {
                key.1 += 1;
            }
            all.insert(key, Shown::of(dataset, argument));
        }
        all
    };
    let (old, new) = (arguments(a, before), arguments(b, after));
    let keys: BTreeSet<_> = old.keys().chain(new.keys()).collect();
    for key in keys {
        let (old, new) = (old.get(key), new.get(key));
        if let (Some(old), Some(new)) = (old, new)
            && old.same(new, same)
        {
            continue;
        }
        out.push(Change {
            address: format!("{address}.{}", key.0),
            before: old.map(Shown::text),
            after: new.map(Shown::text),
        });
    }
}

/// What an argument says, without its spelling.
enum Shown {
    Numbers(Vec<f64>),
    Text(String),
}

impl Shown {
    fn of(dataset: &Dataset, argument: &Argument) -> Self {
        let source = dataset.source();
        let plain = |text: &str| text.split_whitespace().collect::<String>();
        match &argument.value {
            Value::Numbers(_) => {
                Self::Numbers(argument.numbers().iter().map(|n| n.value).collect())
            }
            Value::Words(_) => {
                let words = argument.choices(source);
                if words.is_empty() {
                    Self::Text(argument.texts(source).join(":"))
                } else {
                    Self::Text(words.join(":"))
                }
            }
            Value::Texts(_) => Self::Text(argument.texts(source).join(":")),
            Value::Function(expression) => Self::Text(plain(&expression.text)),
            Value::Flag => Self::Text(String::new()),
            Value::User(span) | Value::Malformed(span) => Self::Text(plain(&source.text(*span))),
        }
    }

    fn same(&self, other: &Self, same: &impl Fn(f64, f64) -> bool) -> bool {
        match (self, other) {
            (Self::Numbers(a), Self::Numbers(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(x, y)| same(*x, *y))
            }
            (Self::Text(a), Self::Text(b)) => a == b,
            _ => false,
        }
    }

    fn text(&self) -> String {
        match self {
            Self::Numbers(numbers) => {
                let all: Vec<String> = numbers.iter().map(ToString::to_string).collect();
                all.join(", ")
            }
            Self::Text(text) => text.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::Source;

    fn between(a: &str, b: &str) -> Vec<String> {
        let read = |text: &str| Dataset::parse(Source::new("x", text.as_bytes())).value;
        changes(&read(a), &read(b), |x, y| (x - y).abs() <= 1e-9)
            .iter()
            .map(Change::line)
            .collect()
    }

    #[test]
    fn layout_says_nothing_and_values_do() {
        let a = "t\nPART/1, GROUND\nMARKER/1, PART=1, QP=1,2,3\nSFORCE/3, I=1, J=2, TRANS, FUNCTION=2*TIME\nEND\n";
        let b = "t\n! moved\nMARKER/01\n, QP = 1.0, 2.0E+00, 3\n, PART = 1\nPART/1\n, GROUND\nSFORCE/3, I=1, J=2, TRANSLATIONAL\n, FUNC = 2 * TIME\nEND\n";
        assert_eq!(between(a, b), Vec::<String>::new());
        let c = a
            .replace("QP=1,2,3", "QP=1,2.5,3")
            .replace("PART/1, GROUND\n", "");
        assert_eq!(
            between(a, &c),
            ["MARKER/1.QP: 1, 2, 3 -> 1, 2.5, 3\n", "- PART/1 \n"]
        );
    }
}
