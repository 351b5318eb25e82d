use std::path::PathBuf;

use clap_complete::ArgValueCompleter;
use serde_json::{Value, json};

use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::{STATEMENTS, ValueKind};
use crate::syntax::{self, Address, Argument, Dataset};

use super::Outcome;
use super::addresses::complete;
use super::shell::{Exit, Format, Shell};

/// Print values of a dataset.
///
/// Numbers are in the deck's units, angles in radians; what is not written has its default.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// `BUSHING/12.K.2`, `front_arm_bushing.K`, `SFORCE/3`, ...
    #[arg(required = true, add = ArgValueCompleter::new(complete))]
    addresses: Vec<String>,
}

/// Prints a value per line.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = shell.read(&arguments.deck)?;
    let dataset = Dataset::parse(source).value;
    let mut found = serde_json::Map::new();
    let mut out = String::new();
    let mut refused = None;
    for text in &arguments.addresses {
        let value = match parse(text, &dataset, shell) {
            Ok(address) => value(&dataset, &address).map_err(|diagnostic| shell.fail(diagnostic)),
            Err(exit) => Err(exit),
        };
        let value = match value {
            Ok(value) => value,
            Err(exit) => {
                refused = Some(exit);
                continue;
            }
        };
        out += &match &value {
            Value::String(text) => text.clone(),
            Value::Array(values) => values.iter().map(plain).collect::<Vec<_>>().join(", "),
            other => other.to_string(),
        };
        out.push('\n');
        found.insert(text.clone(), value);
    }
    // Who asked for several values counts lines: all of them or none.
    if let Some(exit) = refused {
        return Err(exit);
    }
    shell.print(&if shell.format == Format::Json {
        serde_json::to_string_pretty(&found).expect("JSON values print") + "\n"
    } else {
        out
    });
    Ok(Exit::Fine)
}

/// An address of the command line.
pub(super) fn parse(text: &str, dataset: &Dataset, shell: &Shell) -> Result<Address, Exit> {
    Address::parse(text, dataset).map_err(|mut diagnostic: Diagnostic| {
        // The command line is no file to show places in.
        diagnostic.labels.clear();
        diagnostic.message = format!("`{text}`: {}", diagnostic.message);
        shell.complain(&[diagnostic]);
        Exit::Findings
    })
}

fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// A number, a list of numbers, a text, or the statement as it is written; what is not written has its default.
fn value(dataset: &Dataset, address: &Address) -> Result<Value, Diagnostic> {
    let source = dataset.source();
    if address.kind == "TITLE" {
        return Ok(json!(dataset.title()));
    }
    let statement = dataset.find(address);
    let Some(name) = &address.argument else {
        return Ok(statement.map_or(Value::Null, |found| json!(source.text(found.span))));
    };
    let def = STATEMENTS
        .iter()
        .find(|def| def.name == address.kind)
        .and_then(|def| def.arguments.iter().find(|argument| argument.name == name));
    let whole =
        def.is_some_and(|def| matches!(def.kind, ValueKind::Integer | ValueKind::Reference(_)));
    let number = |value: f64| {
        if whole && value.fract() == 0.0 {
            json!(value as i64)
        } else {
            json!(value)
        }
    };
    if let Some(value) = dataset.value_at(address) {
        return Ok(number(value));
    }
    let written = statement.and_then(|statement| Some((statement, statement.argument(name)?)));
    let Some((statement, argument)) = written else {
        let default = def.map_or(&[][..], |def| def.default);
        return match address.index {
            Some(index) => {
                let room = def.and_then(|def| def.count.max);
                match default.get(index - 1) {
                    Some(value) => Ok(number(*value)),
                    None if room.is_none_or(|most| index <= most) => Ok(Value::Null),
                    None => Err(beyond(address, room)),
                }
            }
            None if default.is_empty() => Ok(Value::Null),
            None => Ok(default.iter().copied().map(number).collect()),
        };
    };
    let numbers: Vec<Value> = statement
        .all(name)
        .flat_map(Argument::numbers)
        .map(|one| number(one.value))
        .collect();
    let texts = argument.texts(source);
    let mut values = if numbers.is_empty() {
        texts.iter().map(|text| json!(text)).collect()
    } else {
        numbers
    };
    match address.index {
        Some(index) if index <= values.len() => Ok(values.swap_remove(index - 1)),
        Some(_) => {
            let literals = match &argument.value {
                syntax::Value::Function(expression) => expression.literals.len(),
                _ => values.len(),
            };
            Err(beyond(address, Some(literals)).label(source.name(), argument.span, ""))
        }
        None => Ok(match (values.len(), argument.text(source)) {
            (0, Some(text)) => json!(text),
            (0, None) => match &argument.value {
                syntax::Value::Flag => json!(true),
                _ => json!(source.text(argument.value_span())),
            },
            (1, _) => values.swap_remove(0),
            _ => Value::Array(values),
        }),
    }
}

/// There is no value at such a place.
fn beyond(address: &Address, count: Option<usize>) -> Diagnostic {
    let count = count.unwrap_or(0);
    let what = Address {
        index: None,
        ..address.clone()
    };
    let values = if count == 1 { "value" } else { "values" };
    Diagnostic::error(
        Code::OutOfRange,
        format!("{address} is not there: {what} has {count} {values}"),
    )
}
