use std::path::PathBuf;

use clap_complete::ArgValueCompleter;

use crate::diagnostic::{Code, Diagnostic};
use crate::syntax::Dataset;

use super::Outcome;
use super::addresses::complete;
use super::edited::{edited, refuse_faults};
use super::get::parse;
use super::shell::{Exit, Shell};
use super::target::Target;

/// Take statements out of a dataset, with the comments that name them, or arguments out of statements.
///
/// Nothing else of the deck changes. Without -o or --in-place the new deck goes to standard output.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// `JOINT/3`, `front_arm_bushing`, `BUSHING/12.PRELOAD`, ...
    #[arg(required = true, value_name = "ADDRESS", add = ArgValueCompleter::new(complete))]
    addresses: Vec<String>,
    /// Write a deck with new faults too, such as references to what is gone.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    target: Target,
}

/// Writes the smaller deck.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = shell.read(&arguments.deck)?;
    let original = Dataset::parse(source);
    let mut deck = original.clone();
    for text in &arguments.addresses {
        // Names are those of the deck as it was, whatever has gone meanwhile.
        let address = parse(text, &original.value, shell)?;
        let edits = if address.index.is_some() {
            let message = format!("`{text}` is one value of a list");
            Err(Diagnostic::error(Code::WrongType, message)
                .help("statements and arguments can be removed"))
        } else {
            deck.value.remove(&address)
        };
        let edits = edits.map_err(|refused| shell.fail(refused))?;
        deck = edited(&deck.value, &edits, shell)?;
        shell.sources.add(deck.value.source().clone());
    }
    refuse_faults(&original, &deck, arguments.force, shell)?;
    arguments
        .target
        .deliver(&arguments.deck, deck.value.bytes(), shell)?;
    Ok(Exit::Fine)
}
