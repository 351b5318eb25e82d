use std::path::PathBuf;

use crate::diagnostic::{Code, Diagnostic};
use crate::syntax::{Dataset, json};
use crate::text::apply_edits;

use super::Outcome;
use super::shell::{Exit, Shell};
use super::target::Target;

/// Bring changes of an exported JSON back into the dataset it came from.
///
/// Only what differs is edited; everything else keeps its bytes. Without -o or --in-place the new deck goes to standard output.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// The dataset that was exported.
    deck: PathBuf,
    /// The JSON, as `admire export` wrote it, with changes; `-` is standard input.
    json: PathBuf,
    #[command(flatten)]
    target: Target,
}

/// Writes the changed deck.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = shell.read(&arguments.deck)?;
    let dataset = Dataset::parse(source).value;
    let text = shell.read(&arguments.json)?;
    let read = serde_json::from_slice(text.bytes()).map_err(|error| {
        shell.fail(Diagnostic::error(
            Code::SyntaxError,
            format!("`{}` is no JSON: {error}", text.name()),
        ))
    })?;
    let edits = json::import(&dataset, &read).map_err(|complaints| {
        shell.complain(&complaints);
        Exit::Findings
    })?;
    let bytes = apply_edits(dataset.bytes(), &edits).map_err(|conflict| {
        shell.fail(Diagnostic::error(Code::CannotWrite, conflict.to_string()))
    })?;
    arguments.target.deliver(&arguments.deck, &bytes, shell)?;
    Ok(Exit::Fine)
}
