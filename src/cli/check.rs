use std::path::{Path, PathBuf};

use crate::diagnostic::Diagnostic;
use crate::model::Model;
use crate::syntax::{CommandFile, Dataset};

use super::Outcome;
use super::shell::{Exit, Shell, exit_of};

/// Check datasets and command files.
///
/// Prints what is wrong with them, each complaint at its place. Exit code 1 if there is an error among the complaints.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Datasets (.adm) and command files (.acf).
    #[arg(required = true)]
    files: Vec<PathBuf>,
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
            found.extend(CommandFile::parse(source).diagnostics);
        } else {
            let parsed = Dataset::parse(source);
            found.extend(parsed.diagnostics);
            found.extend(Model::lower(&parsed.value).diagnostics);
        }
    }
    shell.findings(&found);
    if unread {
        return Err(Exit::Failed);
    }
    Ok(exit_of(&found))
}

/// True for `.acf` files, in any case of letters.
pub(super) fn is_command_file(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("acf"))
}
