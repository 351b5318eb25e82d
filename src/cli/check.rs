use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::diagnostic::{Code, Diagnostic};
use crate::model::{self, Model};
use crate::syntax::lint::Options;
use crate::syntax::property::PropertyFile;
use crate::syntax::{self, CommandFile, Dataset};
use crate::text::Source;

use super::Outcome;
use super::shell::{Exit, Shell, exit_of};

/// Check datasets, command files and property files.
///
/// Prints what is wrong with them, each complaint at its place. Exit code 1 if there is an error among the complaints.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Datasets (.adm), command files (.acf) and property files of Adams/Car (.bus, .spr, ...).
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// The decks are for the FORTRAN solver: also report lines it would cut off.
    #[arg(long)]
    fortran: bool,
}

/// Prints the complaints about all files.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let mut found: Vec<Diagnostic> = Vec::new();
    let mut unread = false;
    for path in &arguments.files {
        let Ok(source) = shell.read(path) else {
            unread = true;
            continue;
        };
        if is_command_file(path) {
            let commands = CommandFile::parse(source);
            let mut own = commands.diagnostics;
            own.extend(syntax::lint::check_commands(&commands.value));
            own.sort_by_key(|diagnostic| diagnostic.labels.first().map(|l| l.span.start()));
            found.extend(own);
        } else if PropertyFile::is_one(source.bytes()) {
            found.extend(PropertyFile::parse(source).diagnostics);
        } else {
            found.extend(of_dataset(source, arguments.fortran, shell));
        }
    }
    shell.findings(&found);
    if unread {
        return Err(Exit::Findings);
    }
    Ok(exit_of(&found))
}

/// Everything there is to say of a dataset, each fault once, in the order of the file.
fn of_dataset(source: Source, fortran: bool, shell: &mut Shell) -> Vec<Diagnostic> {
    let read = Dataset::parse(source);
    let dataset = &read.value;
    let files = shell.read_files(dataset);
    let resolved = Model::lower_with(dataset, &files.value);
    let mut found = read.diagnostics;
    found.extend(files.diagnostics);
    found.extend(syntax::lint::check(dataset, &Options { fortran }));
    let seen: BTreeSet<_> = found.iter().map(place).collect();
    let mut own = BTreeSet::new();
    // The reader of the model meets some faults of statements again.
    for diagnostic in resolved.diagnostics {
        let no_ground =
            diagnostic.code == Code::NoGround && found.iter().any(|f| f.code == Code::NoGround);
        let whole = diagnostic.labels.first().map(|label| label.span);
        let new = !seen.contains(&place(&diagnostic)) && own.insert((diagnostic.code, whole));
        if new && !no_ground {
            found.push(diagnostic);
        }
    }
    found.extend(model::lint::check(dataset, &resolved.value));
    found.sort_by_key(|diagnostic| diagnostic.labels.first().map(|label| label.span.start()));
    found
}

/// What is said and where that begins: one points at the keyword, the other at keyword and id.
fn place(diagnostic: &Diagnostic) -> (Code, Option<usize>) {
    let label = diagnostic.labels.first();
    (diagnostic.code, label.map(|label| label.span.start()))
}

/// True for `.acf` files, in any case of letters.
pub(super) fn is_command_file(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("acf"))
}
