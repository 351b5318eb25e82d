use std::path::PathBuf;

use clap_complete::ArgValueCompleter;

use crate::diagnostic::{Checked, Code, Diagnostic};
use crate::grammar::{STATEMENTS, ValueKind};
use crate::syntax::{Address, Dataset, number};
use crate::text::{Edit, Source};

use super::Outcome;
use super::addresses::complete;
use super::edited::{edited, new_errors, same_but_for, still_good};
use super::get::parse;
use super::shell::{Exit, Shell};
use super::target::Target;

/// Change values of a dataset; only their own bytes change.
///
/// A number is in the deck's units, an angle in radians or with the suffix D; `true` and `false` switch a flag
/// (`MARKER/7.FLOATING=true`); anything else is written as it is in place of the whole value (`SFORCE/3.FUNCTION=10*TIME`,
/// `TITLE=new`), if the deck can be read then; what `admire check` finds wrong with it is told. Without assignments the copy is
/// identical. Without -o or --in-place the new deck goes to standard output.
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
    let original = Dataset::parse(source);
    let mut deck = original.clone();
    let mut refused = None;
    for assignment in &arguments.assignments {
        match changed(&deck, assignment, shell) {
            Ok(changed) => deck = changed,
            // The others are looked at too, so that all faults are told at once.
            Err(exit) => refused = Some(exit.max(refused.unwrap_or(exit))),
        }
    }
    if let Some(exit) = refused {
        return Err(exit);
    }
    if !still_good(&original.value, &deck.value, shell) {
        return Err(not_written(&arguments.assignments.join(" "), shell));
    }
    arguments
        .target
        .deliver(&arguments.deck, deck.value.bytes(), shell)?;
    Ok(Exit::Fine)
}

/// The deck after one assignment.
fn changed(
    deck: &Checked<Dataset>,
    assignment: &str,
    shell: &mut Shell,
) -> Result<Checked<Dataset>, Exit> {
    let Some((address, value)) = assignment.split_once('=') else {
        return Err(shell.usage(
            Diagnostic::error(Code::BadNumber, format!("`{assignment}` has no `=`"))
                .help("write ADDRESS=VALUE"),
        ));
    };
    let dataset = &deck.value;
    let address = parse(address, dataset, shell)?;
    let value = value.trim();
    let edits = edits(dataset, &address, value).map_err(|diagnostic| {
        // A function that cannot be read is shown by itself.
        shell
            .sources
            .add(Source::new("expression", value.as_bytes()));
        shell.fail(diagnostic)
    })?;
    let changed = edited(dataset, &edits, shell)?;
    let place = dataset.position(&address.kind, address.id);
    let argument = address.argument.as_deref().unwrap_or("FUNCTION");
    let new = new_errors(deck, &changed);
    if let Some(first) = new.first() {
        // The place is one of the text as it would be.
        let before = shell.sources.get(dataset.source().name()).cloned();
        shell.sources.add(changed.value.source().clone());
        shell.complain(&[(*first).clone()]);
        shell
            .sources
            .add(before.unwrap_or_else(|| dataset.source().clone()));
        return Err(not_written(assignment, shell));
    }
    if !same_but_for(dataset, &changed.value, place, argument) {
        let message = format!("`{assignment}` would change more than {address}");
        return Err(shell.fail(
            Diagnostic::error(Code::SyntaxError, message)
                .help("change each argument by its own address"),
        ));
    }
    Ok(changed)
}

/// A flag is switched by true and false, a number is spelled like the old one, anything else is written as it is.
fn edits(dataset: &Dataset, address: &Address, value: &str) -> Result<Vec<Edit>, Diagnostic> {
    if address.kind == "TITLE" {
        return dataset.set_text(address, value);
    }
    if is_flag(address) {
        return match value.to_ascii_lowercase().as_str() {
            "true" => dataset.set_flag(address, true),
            "false" => dataset.set_flag(address, false),
            _ => Err(Diagnostic::error(
                Code::WrongType,
                format!("{address} is a flag, it cannot be `{value}`"),
            )
            .help("write =true or =false")),
        };
    }
    let Some((number, degrees)) = number::parse_number(value.as_bytes()) else {
        return dataset.set_text(address, value);
    };
    let edits = dataset.set(address, number)?;
    let old = dataset.number_at(address);
    match (edits.as_slice(), old) {
        // Who writes degrees in place of radians means the suffix.
        ([edit], Some(old))
            if degrees && !old.degrees && edit.span == old.span && number >= 0.0 =>
        {
            Ok(vec![Edit::new(edit.span, value)])
        }
        _ => Ok(edits),
    }
}

fn is_flag(address: &Address) -> bool {
    let def = STATEMENTS.iter().find(|def| def.name == address.kind);
    let argument = def.and_then(|def| {
        def.arguments
            .iter()
            .find(|argument| address.argument.as_deref() == Some(argument.name))
    });
    argument.is_some_and(|argument| argument.kind == ValueKind::Flag)
}

fn not_written(assignment: &str, shell: &Shell) -> Exit {
    shell.fail(Diagnostic::error(
        Code::WrongType,
        format!("`{assignment}` is not written: the deck could not be read with it"),
    ))
}
