use std::path::PathBuf;

use crate::front::Before;
use admire_session::check::is_command_file;
use admire_solver::model::{Model, convert_units};
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::grammar::nearest;
use admire_syntax::units::{FORCE_UNITS, LENGTH_UNITS, MASS_UNITS, TIME_UNITS, Unit};

use super::Outcome;
use super::edited::{edited, refuse_faults};
use super::shell::{Exit, Shell};
use super::target::Target;

/// Write a dataset in other units: the same mechanism, number by number.
///
/// Numbers with a unit are scaled, and so is what functions yield and measure; numbers inside of functions, variables, splines and
/// tolerances that judge lengths and angles alike stay; command files are not converted. What cannot be converted (user subroutines,
/// flexible bodies, contacts, ...) is named, and nothing is written.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// `mmks` (mm, N, kg, s), `mks` (m), `cgs` (cm, dyne, g), `ips` (inch, lbf, lbm), or units by name: `meter,newton`.
    #[arg(long, value_name = "UNITS")]
    to: String,
    #[command(flatten)]
    target: Target,
}

const EXAMPLES: &str = "Examples:
  admire convert-units deck.adm --to mks -o deck_m.adm
  admire convert-units deck.adm --to inch,pound_force,pound_mass --in-place";

/// Writes the converted deck.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    if is_command_file(&arguments.deck) {
        return Err(shell.usage(
            Diagnostic::error(Code::WrongUnits, "a command file is not converted")
                .help("its numbers mean something beside a dataset only: write them anew"),
        ));
    }
    let source = shell.read(&arguments.deck)?;
    let parsed = Dataset::parse(source);
    let dataset = &parsed.value;
    let files = shell.read_files(dataset);
    let model = Model::lower_with(dataset, &files.value);
    let old = &model.value.units;
    let units = asked(&arguments.to, [old.force, old.mass, old.length, old.time])
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
            .help("their times, redefined values and tolerances are numbers of the old units"),
        );
    }
    shell.complain(&said);
    arguments
        .target
        .deliver(&arguments.deck, deck.value.bytes(), shell)?;
    Ok(Exit::Fine)
}

/// Systems by the names ADAMS/View gives them.
const SYSTEMS: [(&str, [&str; 4]); 4] = [
    ("MMKS", ["NEWTON", "KILOGRAM", "MILLIMETER", "SECOND"]),
    ("MKS", ["NEWTON", "KILOGRAM", "METER", "SECOND"]),
    ("CGS", ["DYNE", "GRAM", "CENTIMETER", "SECOND"]),
    ("IPS", ["POUND_FORCE", "POUND_MASS", "INCH", "SECOND"]),
];

/// The units a text asks for; what it does not name stays.
fn asked(text: &str, old: [Unit; 4]) -> Result<[Unit; 4], Diagnostic> {
    let tables = [FORCE_UNITS, MASS_UNITS, LENGTH_UNITS, TIME_UNITS];
    let mut units = old;
    let system = SYSTEMS
        .iter()
        .find(|(name, _)| name.eq_ignore_ascii_case(text.trim()));
    let words: Vec<&str> = match system {
        Some((_, words)) => words.to_vec(),
        None => text.split(',').map(str::trim).collect(),
    };
    for word in words {
        let found = tables.iter().enumerate().find_map(|(k, table)| {
            let same = |unit: &&Unit| {
                unit.keyword.eq_ignore_ascii_case(word) || unit.word.eq_ignore_ascii_case(word)
            };
            Some((k, *table.iter().find(same)?))
        });
        let Some((k, unit)) = found else {
            let known = tables
                .iter()
                .flat_map(|table| table.iter().map(|unit| unit.keyword));
            let known = known.chain(SYSTEMS.iter().map(|(name, _)| *name));
            let help = match nearest(word, known) {
                Some(near) => format!("did you mean {}?", near.to_lowercase()),
                None => "write mmks, mks, cgs, ips, or units such as meter,newton".to_string(),
            };
            let message = format!("`{word}` is not a unit");
            return Err(Diagnostic::error(Code::BadSetting, message).help(help));
        };
        units[k] = unit;
    }
    Ok(units)
}
