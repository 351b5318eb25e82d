use std::collections::BTreeSet;
use std::path::PathBuf;

use clap_complete::ArgValueCompleter;

use crate::front::{Before, edits, new_errors, structure_digest};
use admire_session::check::is_command_file;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::property::PropertyFile;
use admire_syntax::text::{Edit, EditConflict, Source};
use admire_syntax::{Address, Dataset, MarkerPoints};

use super::Outcome;
use super::addresses::complete;
use super::assignment::{Assignment, expanded};
use super::car_edits;
use super::command_edits;
use super::edited::refuse_faults;
use super::shell::{Exit, Shell};
use super::target::Target;

/// Change values of a dataset, of a command file or of a file of Adams/Car; only their own bytes change.
///
/// A number is in the deck's units. An angle is in radians, or in degrees with the suffix D. `true` and `false` switch a flag
/// (`MARKER/7.FLOATING=true`). Any other text replaces the whole value as it is (`SFORCE/3.FUNCTION=10*TIME`, `TITLE=new`). A deck in which
/// `admire check` would find a new error is written only with --force. Without assignments, the copy is identical. Without -o or
/// --in-place, the new deck goes to standard output.
///
/// `*` in an address matches any id or name, or every value of an argument. `*=`, `/=`, `+=` and `-=` compute the new value from the
/// present value. A marker is moved without rotation: ZP and XP move along with QP. In a command file (.acf), a command is named KIND or
/// KIND/id, with #2 for the second of several. In a file of Adams/Car (.sub, .asy, .bus, .spr, .tir, ...), a value is BLOCK.KEY or
/// BLOCK/ROW.COLUMN.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// The dataset, command file or file of Adams/Car.
    deck: PathBuf,
    /// Assignments, such as `BUSHING/12.K.2=15000`, `front_arm_bushing.K=1,2,3`.
    #[arg(value_name = "ADDRESS=VALUE", add = ArgValueCompleter::new(complete))]
    assignments: Vec<String>,
    /// Write the deck even if it has new faults, such as a negative stiffness.
    #[arg(long)]
    force: bool,
    /// Numbers for angles are in degrees. Without this option, they are in radians unless they have the suffix D.
    #[arg(long)]
    degrees: bool,
    #[command(flatten)]
    target: Target,
}

const EXAMPLES: &str = "Examples:
  admire set deck.adm BUSHING/12.K.2=15000 -o new.adm
  admire set deck.adm 'BUSHING/*.K.1*=1.2' --in-place
  admire set deck.adm 'front_*.KT.**=0.9' MARKER/7.QP.3+=5
  admire set deck.adm MARKER/7.REULER.1=30 --degrees
  admire set run.acf SIMULATE#2.END=4 EQUILIBRIUM.MAXIT=200
  admire set front.sub HARDPOINT/lca_outer.y_value=-701.5 -o new.sub
  admire set soft.bus 'FX_CURVE/*.fx*=1.2' --in-place";

/// Applies the assignments and writes the deck.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = arguments.target.read(&arguments.deck, shell)?;
    if PropertyFile::is_one(source.bytes()) {
        let file = car_edits::set(source, &arguments.assignments, arguments.force, shell)?;
        arguments.target.deliver(&arguments.deck, &file, shell)?;
        return Ok(Exit::Fine);
    }
    if is_command_file(&arguments.deck) {
        let file = command_edits::set(
            source,
            &arguments.assignments,
            arguments.force,
            arguments.degrees,
            shell,
        )?;
        arguments.target.deliver(&arguments.deck, &file, shell)?;
        return Ok(Exit::Fine);
    }
    let mut deck = Dataset::parse(source);
    let before = Before::of(&deck);
    let points = MarkerPoints::of(&deck.value);
    let named = named(&arguments.assignments, &deck.value);
    let beside: BTreeSet<&Address> = named.iter().collect();
    let mut refused = None;
    for assignment in &arguments.assignments {
        // The remaining assignments are still checked, so that all faults are reported at once.
        if let Err(exit) = change(&mut deck, (assignment, &beside), arguments.degrees, shell) {
            refused = Some(exit.max(refused.unwrap_or(exit)));
        }
    }
    if let Some(exit) = refused {
        return Err(exit);
    }
    shell.sources.add(deck.value.source().clone());
    refuse_faults(&before, &deck, arguments.force, shell)?;
    shell.complain(&points.moved(&deck.value));
    arguments
        .target
        .deliver(&arguments.deck, deck.value.bytes(), shell)?;
    Ok(Exit::Fine)
}

/// Returns the addresses that the assignments set. Invalid assignments are left out.
fn named(assignments: &[String], dataset: &Dataset) -> Vec<Address> {
    let addresses = assignments.iter().filter_map(|assignment| {
        let left = Assignment::left(assignment)?;
        Address::matching(left, dataset).ok()
    });
    addresses.flatten().collect()
}

/// Applies one assignment, which may set the values at many addresses. `beside` contains the addresses of all assignments. The deck is
/// unchanged if the assignment is refused.
fn change(
    deck: &mut Checked<Dataset>,
    (assignment, beside): (&str, &BTreeSet<&Address>),
    degrees: bool,
    shell: &mut Shell,
) -> Result<(), Exit> {
    let all = expanded(assignment, &deck.value, degrees, shell)?;
    let edits = edits_of(&deck.value, (&all, beside), shell)?;
    match deck.value.text_after(&edits) {
        // Missing arguments would all be inserted at the same place, so they are written one after the other.
        Err(_) if all.len() > 1 => {
            let before = deck.value.source().clone();
            let one_by_one = all.iter().try_for_each(|one| {
                let one = std::slice::from_ref(one);
                let edits = edits_of(&deck.value, (one, beside), shell)?;
                let text = deck.value.text_after(&edits);
                look_at(deck, text, one, assignment, shell)
            });
            if one_by_one.is_err() {
                deck.diagnostics = deck.value.reread(before);
            }
            one_by_one
        }
        text => look_at(deck, text, &all, assignment, shell),
    }
}

/// Creates the edits of the given assignments to the current deck.
fn edits_of(
    dataset: &Dataset,
    (assignments, beside): (&[(Address, String)], &BTreeSet<&Address>),
    shell: &mut Shell,
) -> Result<Vec<Edit>, Exit> {
    let mut all = Vec::new();
    for (address, value) in assignments {
        all.extend(
            edits(dataset, address, value, beside).map_err(|diagnostic| {
                // If a function cannot be parsed, its text is shown on its own.
                shell
                    .sources
                    .add(Source::new("expression", value.as_bytes()));
                shell.fail(diagnostic)
            })?,
        );
    }
    Ok(all)
}

/// Parses the edited text, and keeps it if it has no new errors and if nothing besides the assigned values has changed. Otherwise the deck
/// is unchanged.
fn look_at(
    deck: &mut Checked<Dataset>,
    text: Result<Source, EditConflict>,
    assigned: &[(Address, String)],
    assignment: &str,
    shell: &mut Shell,
) -> Result<(), Exit> {
    let text = text.map_err(|conflict| {
        shell.fail(Diagnostic::error(Code::CannotWrite, conflict.to_string()))
    })?;
    let dataset = &deck.value;
    let places: BTreeSet<(usize, &str)> = assigned
        .iter()
        .filter_map(|(address, _)| {
            let argument = address.argument.as_deref().unwrap_or("FUNCTION");
            Some((dataset.position(&address.kind, address.id)?, argument))
        })
        .collect();
    let expected = structure_digest(dataset, &places);
    let before = dataset.source().clone();
    let known = std::mem::take(&mut deck.diagnostics);
    deck.diagnostics = deck.value.reread(text);
    let refused = if let Some(first) = new_errors(&known, deck).first() {
        // The place of the diagnostic refers to the edited text.
        let shown = shell.sources.get(before.name()).cloned();
        shell.sources.add(deck.value.source().clone());
        shell.complain(&[(*first).clone()]);
        shell.sources.add(shown.unwrap_or_else(|| before.clone()));
        not_written(assignment, shell)
    } else if structure_digest(&deck.value, &places) != expected {
        let message = format!("`{assignment}` would change more than the named value");
        shell.fail(
            Diagnostic::error(Code::SyntaxError, message)
                .help("change each argument by an assignment of its own"),
        )
    } else {
        return Ok(());
    };
    deck.diagnostics = deck.value.reread(before);
    Err(refused)
}

fn not_written(assignment: &str, shell: &Shell) -> Exit {
    shell.fail(Diagnostic::error(
        Code::WrongType,
        format!("nothing is written: `{assignment}` makes the deck unreadable, as shown above"),
    ))
}
