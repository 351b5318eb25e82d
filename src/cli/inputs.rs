//! Input files that a command line names: files, folders and patterns.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use admire_syntax::diagnostic::{Code, Diagnostic};

use super::shell::{Exit, Shell};

/// Expands the words of a command line into files, in order and without duplicates. A folder is expanded into all datasets and command
/// files below it, in alphabetical order. A pattern such as `runs/*.adm` is expanded here if the shell has not done so.
pub(super) fn files_of(words: &[PathBuf], shell: &Shell) -> Result<Vec<PathBuf>, Exit> {
    let mut seen = BTreeSet::new();
    let mut files = Vec::new();
    for word in words {
        let found = if word.is_dir() {
            below(word)
        } else if word.exists() || word == Path::new("-") || !is_pattern(word) {
            vec![word.clone()]
        } else {
            matching(word, shell)?
        };
        if found.is_empty() {
            let what = if word.is_dir() {
                format!(
                    "there is no dataset (.adm) or command file (.acf) below `{}`",
                    word.display()
                )
            } else {
                format!("no file matches the pattern `{}`", word.display())
            };
            return Err(shell.fail(Diagnostic::error(Code::CannotRead, what)));
        }
        files.extend(found.into_iter().filter(|file| seen.insert(file.clone())));
    }
    Ok(files)
}

fn is_pattern(word: &Path) -> bool {
    word.to_string_lossy().contains(['*', '?', '['])
}

fn matching(pattern: &Path, shell: &Shell) -> Result<Vec<PathBuf>, Exit> {
    let paths = glob::glob(&pattern.to_string_lossy()).map_err(|error| {
        let message = format!("`{}` is not a valid pattern: {error}", pattern.display());
        shell.usage(Diagnostic::error(Code::CannotRead, message))
    })?;
    Ok(paths
        .flatten()
        .flat_map(|path| {
            if path.is_dir() {
                below(&path)
            } else {
                vec![path]
            }
        })
        .collect())
}

/// Finds the datasets and command files below a folder. Hidden entries are left out, and links are not followed.
fn below(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| {
            let name = path.file_name().unwrap_or_default();
            !name.to_string_lossy().starts_with('.')
        })
        .collect();
    entries.sort();
    let mut files = Vec::new();
    for path in entries {
        if path.is_dir() {
            if !path.is_symlink() {
                files.extend(below(&path));
            }
        } else if path.extension().is_some_and(|end| {
            ["adm", "acf"]
                .iter()
                .any(|known| end.eq_ignore_ascii_case(known))
        }) {
            files.push(path);
        }
    }
    files
}
