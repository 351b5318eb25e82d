use std::path::PathBuf;

use crate::front::{Before, units};
use admire_session::check::is_command_file;
use admire_solver::model::{Model, convert_units};
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::edited::{edited, refuse_faults};
use super::shell::{Exit, Shell};
use super::target::Target;

/// Write a dataset in other units: the same mechanism with converted numbers.
///
/// Numbers with a unit are scaled. Numbers inside functions are unchanged: the measures in a function are converted to the old units, and its result
/// is scaled. Variables, splines, and tolerances that apply to lengths and angles alike are unchanged, too. Command files are not converted. If an
/// item cannot be converted (user subroutines, flexible bodies, contacts, ...), it is named and nothing is written.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// Target units: `mmks` (mm, N, kg, s), `mks` (m), `cgs` (cm, dyne, g), `ips` (inch, lbf, lbm), or units by name: `meter,newton`.
    #[arg(long, value_name = "UNITS")]
    to: String,
    #[command(flatten)]
    target: Target,
}

const EXAMPLES: &str = "Examples:
  admire convert-units deck.adm --to mks -o deck_m.adm
  admire convert-units deck.adm --to inch,pound_force,pound_mass --in-place";

/// Converts the deck and writes it.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    if is_command_file(&arguments.deck) {
        return Err(shell.usage(
            Diagnostic::error(Code::WrongUnits, "a command file cannot be converted").help(
                "the units of its numbers are those of the dataset that it loads: write the numbers in the new units by hand",
            ),
        ));
    }
    let source = shell.read(&arguments.deck)?;
    let parsed = Dataset::parse(source);
    let dataset = &parsed.value;
    let files = shell.read_files(dataset);
    let model = Model::lower_with(dataset, &files.value);
    let old = &model.value.units;
    let units = units(&arguments.to, [old.force, old.mass, old.length, old.time])
        .map_err(|refused| shell.usage(refused))?;
    let converted = convert_units(dataset, &model.value, units).map_err(|refused| {
        shell.complain(&refused);
        Exit::Findings
    })?;
    let deck = edited(dataset, &converted.value, shell)?;
    shell.sources.add(deck.value.source().clone());
    refuse_faults(&Before::of(&parsed), &deck, false, shell)?;
    let mut said = converted.diagnostics;
    dataset.locate(&mut said);
    if !converted.value.is_empty() {
        said.push(
            Diagnostic::note(
                Code::WrongUnits,
                "command files of this dataset are not converted",
            )
            .help("their times, redefined values and tolerances remain in the old units"),
        );
    }
    shell.complain(&said);
    arguments
        .target
        .deliver(&arguments.deck, deck.value.bytes(), shell)?;
    Ok(Exit::Fine)
}
