use std::collections::BTreeSet;
use std::path::PathBuf;

use clap_complete::ArgValueCompleter;

use crate::front::{Before, moving_parts};
use admire_solver::model::{Model, extract};
use admire_syntax::Dataset;
use admire_syntax::diagnostic::Severity;
use admire_syntax::text::printable;

use super::Outcome;
use super::addresses::complete;
use super::edited::{edited, refuse_faults};
use super::shell::{Exit, Shell};
use super::target::Target;

/// Take parts and what hangs on them out of a dataset as a dataset of its own.
///
/// Joints and forces of these parts stay, with all that their functions use. Their other ends are put on ground where the design puts
/// them. Settings, gravity and units stay.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// `PART/7`, `knuckle`, `front_*`, ...
    #[arg(required = true, value_name = "PART", add = ArgValueCompleter::new(complete))]
    parts: Vec<String>,
    /// Write a dataset with new faults too.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    target: Target,
}

const EXAMPLES: &str = "Examples:
  admire extract car.adm knuckle -o knuckle.adm
  admire extract car.adm PART/7 PART/8 | admire check -";

/// Extracts the parts and writes the deck.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = shell.read(&arguments.deck)?;
    let parsed = Dataset::parse(source);
    let dataset = &parsed.value;
    let mut bodies = BTreeSet::new();
    for text in &arguments.parts {
        let parts = moving_parts(dataset, text).map_err(|refused| shell.fail(refused))?;
        bodies.extend(parts);
    }
    let files = shell.read_files(dataset);
    let model = Model::lower_with(dataset, &files.value);
    let edits = extract(dataset, &model.value, &bodies).map_err(|refused| shell.fail(refused))?;
    shell.complain(&edits.diagnostics);
    let deck = edited(dataset, &edits.value, shell)?;
    shell.sources.add(deck.value.source().clone());
    refuse_faults(&Before::of(&parsed), &deck, arguments.force, shell)?;
    arguments
        .target
        .deliver(&arguments.deck, &harmless(deck.value.bytes()), shell)?;
    let worst = edits.diagnostics.iter().map(|found| found.severity).max();
    Ok(match worst {
        Some(Severity::Error) => Exit::Findings,
        _ => Exit::Fine,
    })
}

/// Escapes characters in names and comments that could control a terminal. An extract is a new dataset, so its text need not stay as in the
/// original. Bytes that are not UTF-8 and line ends are kept.
fn harmless(deck: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(deck.len());
    for line in deck.split_inclusive(|byte| matches!(byte, b'\n' | b'\r')) {
        let (text, end) = match line.split_last() {
            Some((end @ (b'\n' | b'\r'), text)) => (text, Some(*end)),
            _ => (line, None),
        };
        for chunk in text.utf8_chunks() {
            out.extend_from_slice(printable(chunk.valid()).as_bytes());
            out.extend_from_slice(chunk.invalid());
        }
        out.extend(end);
    }
    out
}
