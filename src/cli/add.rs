use std::path::PathBuf;

use crate::front::{Before, no_statement, with_statements};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Source;
use admire_syntax::{Dataset, NewStatement};

use super::Outcome;
use super::edited::refuse_faults;
use super::shell::{Exit, Shell};
use super::target::Target;

/// Add statements to a dataset, in the dataset's own style: continuation marks, line endings, name comments.
///
/// A statement is inserted after the last statement of its kind, or before END. Nothing else in the deck changes. Without -o or --in-place,
/// the new deck goes to standard output.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire add front.adm 'MARKER/99, PART=2, QP=1,2,3' --name CENTRE --out new.adm"
)]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// Statements, such as `MARKER/99, PART=2, QP=1,2,3`.
    #[arg(required = true, value_name = "STATEMENT")]
    statements: Vec<String>,
    /// View name of the new statement, if only one is added.
    #[arg(long)]
    name: Option<String>,
    /// Write the deck even if it has new faults, such as a reference to a missing marker.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    target: Target,
}

/// Adds the statements to the deck and writes the deck.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = arguments.target.read(&arguments.deck, shell)?;
    let original = Dataset::parse(source);
    let mut new = Vec::new();
    for text in &arguments.statements {
        let typed = Source::new("statement", text.as_bytes());
        shell.sources.add(typed.clone());
        let read = NewStatement::read(&typed);
        shell.complain(&read.diagnostics);
        if read.value.is_empty() {
            return Err(shell.fail(no_statement(text)));
        }
        new.extend(read.value);
    }
    match (&arguments.name, new.as_mut_slice()) {
        (None, _) => {}
        (Some(name), [one]) if !name.contains(['\'', '\n', '\r']) => {
            one.view_name = Some(name.clone());
        }
        (Some(_), [_]) => {
            let message = "the view name contains a single quote or a line break";
            let help = "the name stands between single quotes in a comment of the dataset";
            return Err(shell.usage(Diagnostic::error(Code::SyntaxError, message).help(help)));
        }
        (Some(_), all) => {
            let message = format!(
                "--name names one statement, but {} statements are to be added",
                all.len()
            );
            let help = "add the named statement by a command of its own";
            return Err(shell.usage(Diagnostic::error(Code::SyntaxError, message).help(help)));
        }
    }
    let deck = with_statements(&original, &new).map_err(|refused| shell.fail(refused))?;
    shell.sources.add(deck.value.source().clone());
    refuse_faults(&Before::of(&original), &deck, arguments.force, shell)?;
    arguments
        .target
        .deliver(&arguments.deck, deck.value.bytes(), shell)?;
    Ok(Exit::Fine)
}
