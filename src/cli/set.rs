use std::path::PathBuf;

use clap_complete::ArgValueCompleter;

use crate::diagnostic::{Checked, Code, Diagnostic, Severity};
use crate::syntax::{Dataset, number};

use super::Outcome;
use super::addresses::complete;
use super::get::parse;
use super::shell::{Exit, Shell};
use super::target::Target;

/// Change values of a dataset; only their own bytes change.
///
/// A number is in the deck's units, an angle in radians or with the suffix D; anything else is written as it is in place of the
/// whole value (`SFORCE/3.FUNCTION=10*TIME`), if the deck can be read then. Without assignments the copy is identical. Without -o or --in-place the new deck
/// goes to standard output.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// `BUSHING/12.K.2=15000`, `front_arm_bushing.K=1,2,3`, ...
    #[arg(value_name = "ADDRESS=VALUE", add = ArgValueCompleter::new(complete))]
    assignments: Vec<String>,
    #[command(flatten)]
    target: Target,
}

/// Writes the changed deck.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = shell.read(&arguments.deck)?;
    let mut deck = Dataset::parse(source);
    for assignment in &arguments.assignments {
        let Some((address, value)) = assignment.split_once('=') else {
            return Err(shell.usage(
                Diagnostic::error(Code::BadNumber, format!("`{assignment}` has no `=`"))
                    .help("write ADDRESS=VALUE"),
            ));
        };
        let dataset = &deck.value;
        let address = parse(address, dataset, shell)?;
        let value = value.trim();
        let edits = match number::parse_number(value.as_bytes()) {
            Some((number, _)) => dataset.set(&address, number),
            None => dataset.set_text(&address, value),
        };
        let edits = edits.map_err(|diagnostic| {
            shell.complain(&[diagnostic]);
            Exit::Findings
        })?;
        let changed = dataset.edited(&edits).map_err(|conflict| {
            shell.fail(Diagnostic::error(Code::CannotWrite, conflict.to_string()))
        })?;
        if errors(&changed) > errors(&deck) {
            // The first one the deck did not have is about the new value.
            let known: Vec<&str> = deck
                .diagnostics
                .iter()
                .map(|d| d.message.as_str())
                .collect();
            let new = changed.diagnostics.iter().filter(|found| {
                found.severity == Severity::Error && !known.contains(&found.message.as_str())
            });
            shell.complain(&new.take(1).cloned().collect::<Vec<_>>());
            return Err(shell.fail(Diagnostic::error(
                Code::WrongType,
                format!("`{assignment}` is not written: the deck could not be read with it"),
            )));
        }
        deck = changed;
    }
    arguments
        .target
        .deliver(&arguments.deck, deck.value.bytes(), shell)?;
    Ok(Exit::Fine)
}

/// How many errors the reading of a deck found.
fn errors(deck: &Checked<Dataset>) -> usize {
    let all = deck.diagnostics.iter();
    all.filter(|found| found.severity == Severity::Error)
        .count()
}
