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

/// Extract parts of a dataset, with everything attached to them, as a separate dataset.
///
/// Joints and forces of these parts are kept, with everything that their functions use. The other ends of these elements are attached to
/// ground at their design positions. Settings, gravity and units are kept.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// Parts to extract, such as `PART/7`, `knuckle`, `front_*`.
    #[arg(required = true, value_name = "PART", add = ArgValueCompleter::new(complete))]
    parts: Vec<String>,
    /// Write the dataset even if it has new faults.
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

/// Escapes characters in names and comments that could control a terminal. An extract is a new dataset, so its text may differ from the
/// original. Line ends and bytes that are not UTF-8 are kept.
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
