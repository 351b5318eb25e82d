use std::path::PathBuf;

use clap_complete::ArgValueCompleter;
use serde_json::Value;

use crate::front::value;
use admire_session::check::is_command_file;
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::property::PropertyFile;
use admire_syntax::{Address, CommandFile, Dataset};

use super::Outcome;
use super::addresses::complete;
use super::car_edits;
use super::command_edits;
use super::format::Format;
use super::shell::{Exit, Shell};

/// Print values of a dataset, of a command file or of a file of Adams/Car.
///
/// Numbers are in the deck's units, with angles in radians or with --degrees in degrees. An argument that is not written has its default value. `*`
/// matches any id or name, or every value of an argument; each value is then printed after its address. In a command file (.acf), a command is named
/// KIND or KIND/id, with #2 for the second of several. In a file of Adams/Car (.sub, .asy, .bus, .spr, .tir, ...), a value is BLOCK.KEY or
/// BLOCK/ROW.COLUMN; a block or row alone prints all its values.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// The dataset, command file or file of Adams/Car.
    deck: PathBuf,
    /// Addresses, such as `BUSHING/12.K.2`, `front_arm_bushing.K`, `SFORCE/3`.
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
  admire get run.acf SIMULATE#2.END 'SIMULATE#*.END'
  admire get front.sub HARDPOINT/lca_outer 'HARDPOINT/*.z_value' UNITS.LENGTH";

/// Prints the values, one per line.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = shell.read(&arguments.deck)?;
    let file = if PropertyFile::is_one(source.bytes()) {
        Looked::Car(PropertyFile::parse(source).value)
    } else if is_command_file(&arguments.deck) {
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
    // A caller that requests several values counts the lines, so either all values or none are printed.
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

/// File from which values are read.
enum Looked {
    Deck(Dataset),
    Commands(CommandFile),
    Car(PropertyFile),
}

/// Returns the values at an address, or at all addresses that match a pattern. Each value is named: by the requested text, or for a pattern
/// by its own address.
fn values(
    file: &Looked,
    text: &str,
    degrees: bool,
    shell: &Shell,
) -> Result<Vec<(String, Value)>, Exit> {
    let mut all = Vec::new();
    match file {
        Looked::Car(file) => all = car_edits::values(file, text, shell)?,
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

/// Reports a faulty address without a place, because the command line is not a file with places.
fn of_text(mut refused: Diagnostic, text: &str, shell: &Shell) -> Exit {
    refused.labels.clear();
    refused.message = format!("`{text}`: {}", refused.message);
    shell.fail(refused)
}

/// Parses an address from the command line.
pub(super) fn parse(text: &str, dataset: &Dataset, shell: &Shell) -> Result<Address, Exit> {
    Address::parse(text, dataset).map_err(|refused| of_text(refused, text, shell))
}

fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}
