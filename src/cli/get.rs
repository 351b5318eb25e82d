use std::path::PathBuf;

use clap_complete::ArgValueCompleter;
use serde_json::{Value, json};

use crate::diagnostic::Diagnostic;
use crate::syntax::{Address, Dataset};

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
    for text in &arguments.addresses {
        let address = parse(text, &dataset, shell)?;
        let value = value(&dataset, &address);
        out += &match &value {
            Value::String(text) => text.clone(),
            Value::Array(values) => values
                .iter()
                .map(Value::to_string)
                .collect::<Vec<_>>()
                .join(", "),
            other => other.to_string(),
        };
        out.push('\n');
        found.insert(text.clone(), value);
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

/// A number, a list of numbers, a text, or the statement as it is written.
fn value(dataset: &Dataset, address: &Address) -> Value {
    if let Some(number) = dataset.value_at(address) {
        return json!(number);
    }
    let Some(statement) = dataset.find(address) else {
        return Value::Null;
    };
    let source = dataset.source();
    let Some(name) = &address.argument else {
        return json!(source.text(statement.span));
    };
    let numbers: Vec<f64> = statement.numbers(name).iter().map(|n| n.value).collect();
    match statement.argument(name) {
        Some(_) if !numbers.is_empty() => json!(numbers),
        Some(argument) => {
            let texts = argument.texts(source);
            match (texts.as_slice(), argument.text(source)) {
                ([], Some(text)) => json!(text),
                ([], None) => json!(true),
                ([one], _) => json!(one),
                (several, _) => json!(several),
            }
        }
        None => match argument_default(statement, name) {
            Some(default) if !default.is_empty() => json!(default),
            _ => Value::Null,
        },
    }
}

fn argument_default(statement: &crate::syntax::Statement, name: &str) -> Option<&'static [f64]> {
    let def = statement.def?;
    let argument = def
        .arguments
        .iter()
        .find(|argument| argument.name == name)?;
    Some(argument.default)
}
