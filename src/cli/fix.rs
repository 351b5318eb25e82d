use std::path::PathBuf;

use similar::TextDiff;

use crate::diagnostic::Applicability;
use crate::syntax::Dataset;
use crate::syntax::lint::{self, Options};
use crate::text::{Edit, Source, Span, apply_edits};

use super::Outcome;
use super::shell::{Exit, Shell};

/// Apply fixes that keep the meaning of a dataset.
///
/// Shows the change; with --write it is made, too.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Datasets (.adm).
    #[arg(required = true)]
    decks: Vec<PathBuf>,
    /// Make the change, after it was shown.
    #[arg(long)]
    write: bool,
}

/// Shows and makes the changes.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let mut exit = Exit::Fine;
    for path in &arguments.decks {
        let Ok(source) = shell.read(path) else {
            exit = Exit::Findings;
            continue;
        };
        let fixed = fixed(&source);
        if fixed == source.bytes() {
            continue;
        }
        shell.print(&diff(&source, &fixed));
        if arguments.write {
            shell.write(path, &fixed)?;
        }
    }
    Ok(exit)
}

/// The file with every safe fix made that does not touch another one.
fn fixed(source: &Source) -> Vec<u8> {
    let parsed = Dataset::parse(source.clone());
    let mut found = parsed.diagnostics;
    found.extend(lint::check(&parsed.value, &Options::default()));
    let mut edits: Vec<Edit> = Vec::new();
    for fix in found.into_iter().filter_map(|diagnostic| diagnostic.fix) {
        let apart = |edit: &Edit| {
            edits
                .iter()
                .all(|made| edit.span.end <= made.span.start || made.span.end <= edit.span.start)
        };
        if fix.applicability == Applicability::Safe && fix.edits.iter().all(apart) {
            edits.extend(fix.edits);
        }
    }
    // Edits that still conflict leave the file as it is.
    apply_edits(source.bytes(), &edits).unwrap_or_else(|_| source.bytes().to_vec())
}

/// The change as a unified diff.
pub(super) fn diff(source: &Source, fixed: &[u8]) -> String {
    let text = |source: &Source| source.text(Span::new(0, source.bytes().len())).into_owned();
    let before = text(source);
    let after = text(&Source::new(source.name(), fixed));
    TextDiff::from_lines(&before, &after)
        .unified_diff()
        .header(source.name(), &format!("{} (changed)", source.name()))
        .to_string()
}
