use std::path::PathBuf;

use crate::front::{Before, new_errors};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::{Dataset, MarkerPoints, json};

use super::Outcome;
use super::edited::{edited, refuse_faults};
use super::shell::{Exit, Shell};
use super::target::Target;

/// Apply the changes in an exported JSON to the dataset that it came from.
///
/// Only values that differ are edited; everything else keeps its bytes. Without -o or --in-place, the new deck goes to standard output.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire export front.adm --json > front.json\n  admire import front.adm front.json"
)]
pub(super) struct Arguments {
    /// The dataset that was exported.
    deck: PathBuf,
    /// Changed JSON, in the form in which `admire export` writes it; `-` is standard input.
    json: PathBuf,
    /// Write the deck even if it has new faults, such as a negative stiffness.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    target: Target,
}

/// Applies the changes to the deck and writes the deck.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = arguments.target.read(&arguments.deck, shell)?;
    let original = Dataset::parse(source);
    let dataset = &original.value;
    let text = shell.read(&arguments.json)?;
    let read = serde_json::from_slice(text.bytes()).map_err(|error| {
        shell.fail(Diagnostic::error(
            Code::SyntaxError,
            format!("`{}` is not JSON: {error}", text.name()),
        ))
    })?;
    let edits = json::import(dataset, &read).map_err(|complaints| {
        shell.complain(&complaints);
        Exit::Findings
    })?;
    let changed = edited(dataset, &edits, shell)?;
    let new = new_errors(&original.diagnostics, &changed);
    if !new.is_empty() {
        shell.sources.add(changed.value.source().clone());
        let new: Vec<Diagnostic> = new.into_iter().cloned().collect();
        shell.complain(&new);
        return Err(not_written("the deck would be unreadable", shell));
    }
    // The changed text must contain exactly the values of the JSON.
    if !edits.is_empty()
        && let Some(first) = json::disagreements(&changed.value, &read).first()
    {
        return Err(not_written(
            &format!("the value of {first} cannot be written as given"),
            shell,
        ));
    }
    shell.sources.add(changed.value.source().clone());
    refuse_faults(&Before::of(&original), &changed, arguments.force, shell)?;
    shell.complain(&MarkerPoints::of(dataset).moved(&changed.value));
    arguments
        .target
        .deliver(&arguments.deck, changed.value.bytes(), shell)?;
    Ok(Exit::Fine)
}

fn not_written(why: &str, shell: &Shell) -> Exit {
    shell.fail(Diagnostic::error(
        Code::WrongType,
        format!("the changes in the JSON are not applied: {why}"),
    ))
}
