use std::path::PathBuf;

use clap_complete::ArgValueCompleter;
use serde_json::{Value, json};

use crate::check::is_command_file;
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::{STATEMENTS, ValueKind};
use crate::syntax::{self, Address, Argument, CommandFile, Dataset};

use super::Outcome;
use super::addresses::complete;
use super::assignment::{is_angle, rounded};
use super::command_edits;
use super::shell::{Exit, Format, Shell};

/// Print values of a dataset.
///
/// Numbers are in the deck's units, angles in radians or with --degrees in degrees; what is not written has its default. `*` stands
/// for any id or name, or for every value of an argument; then every value is printed behind its address. In a command file (.acf)
/// a command is KIND or KIND/id, with #2 for the second one of several.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// The dataset or command file.
    deck: PathBuf,
    /// `BUSHING/12.K.2`, `front_arm_bushing.K`, `SFORCE/3`, ...
    #[arg(required = true, add = ArgValueCompleter::new(complete))]
    addresses: Vec<String>,
    /// Print angles in degrees.
    #[arg(long)]
    degrees: bool,
}

const EXAMPLES: &str = "Examples:
  admire get deck.adm BUSHING/12.K.2 front_arm_bushing.KT
  admire get deck.adm 'BUSHING/*.K' --format json
  admire get deck.adm 'MARKER/*.REULER' --degrees
  admire get run.acf SIMULATE#2.END 'SIMULATE#*.END'";

/// Prints a value per line.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = shell.read(&arguments.deck)?;
    let file = if is_command_file(&arguments.deck) {
        Looked::Commands(CommandFile::parse(source).value)
    } else {
        Looked::Deck(Dataset::parse(source).value)
    };
    let mut found = serde_json::Map::new();
    let mut out = String::new();
    let mut refused = None;
    for text in &arguments.addresses {
        match values(&file, text, arguments.degrees, shell) {
            Ok(all) => {
                for (name, value) in all {
                    if name != *text {
                        out += &format!("{name} = ");
                    }
                    out += &match &value {
                        Value::Array(values) => {
                            values.iter().map(plain).collect::<Vec<_>>().join(", ")
                        }
                        value => plain(value),
                    };
                    out.push('\n');
                    found.insert(name, value);
                }
            }
            Err(exit) => refused = Some(exit),
        }
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

/// What values are taken from.
enum Looked {
    Deck(Dataset),
    Commands(CommandFile),
}

/// The values of an address or a pattern, each with its name: what was asked for, or its own address where a pattern was.
fn values(
    file: &Looked,
    text: &str,
    degrees: bool,
    shell: &Shell,
) -> Result<Vec<(String, Value)>, Exit> {
    let mut all = Vec::new();
    match file {
        Looked::Deck(dataset) if Address::is_pattern(text) => {
            let addresses = Address::matching(text, dataset)
                .map_err(|refused| of_text(refused, text, shell))?;
            for address in addresses {
                let value =
                    value(dataset, &address, degrees).map_err(|refused| shell.fail(refused))?;
                all.push((address.to_string(), value));
            }
        }
        Looked::Deck(dataset) => {
            let address = parse(text, dataset, shell)?;
            let value = value(dataset, &address, degrees).map_err(|refused| shell.fail(refused))?;
            all.push((text.to_string(), value));
        }
        Looked::Commands(commands) => {
            let places = command_edits::places(commands, text)
                .map_err(|refused| of_text(refused, text, shell))?;
            let several = places.len() > 1;
            for (name, one, address) in places {
                let value =
                    value(&one, &address, degrees).map_err(|refused| shell.fail(refused))?;
                all.push((if several { name } else { text.to_string() }, value));
            }
        }
    }
    Ok(all)
}

/// Says what is wrong with an address: the command line is no file to show places in.
fn of_text(mut refused: Diagnostic, text: &str, shell: &Shell) -> Exit {
    refused.labels.clear();
    refused.message = format!("`{text}`: {}", refused.message);
    shell.fail(refused)
}

/// An address of the command line.
pub(super) fn parse(text: &str, dataset: &Dataset, shell: &Shell) -> Result<Address, Exit> {
    Address::parse(text, dataset).map_err(|refused| of_text(refused, text, shell))
}

fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// A number, a list of numbers, a text, or the statement as it is written; what is not written has its default.
fn value(dataset: &Dataset, address: &Address, degrees: bool) -> Result<Value, Diagnostic> {
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
    let in_degrees = degrees && is_angle(address, dataset);
    let number = |value: f64| {
        let value = if in_degrees {
            rounded(value.to_degrees())
        } else {
            value
        };
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
