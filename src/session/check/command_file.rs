use std::path::{Path, PathBuf};

use crate::{FilePolicy, find_file, folder_of};
use admire_syntax as syntax;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::lint::Suppressed;
use admire_syntax::text::{Source, Span};
use admire_syntax::{CommandFile, Dataset};

/// Checks a command file by itself and together with the decks that it names. Returns all diagnostics in the order of the file.
///
/// `deck_of` reads a deck. If it returns `None`, all checks that need this deck are skipped.
pub fn command_file(
    commands: Checked<CommandFile>,
    mut deck_of: impl FnMut(&Path) -> Option<Dataset>,
) -> Vec<Diagnostic> {
    let file = &commands.value;
    let mut found = commands.diagnostics;
    found.extend(syntax::lint::check_commands(file));
    let folder = folder_of(file.source());
    let folders = [folder.clone(), PathBuf::new()];
    let policy = super::policy(&folder);
    let mut of_files = Vec::new();
    let sequence = syntax::lint::check_sequence(file, |name| {
        let path = named(file.source(), name, "adm", &folders, &policy, &mut of_files)?;
        deck_of(&path)
    });
    for command in file.commands() {
        if let Some(inner) = command
            .argument("COMMAND")
            .filter(|_| command.kind() == Some("FILE"))
        {
            named(
                file.source(),
                inner.value_span(),
                "acf",
                &folders,
                &policy,
                &mut of_files,
            );
        }
    }
    found.extend(of_files);
    found.extend(sequence);
    let suppressed = Suppressed::of(file.source(), file.commands());
    found.retain(|diagnostic| !suppressed.covers(diagnostic));
    found.extend(suppressed.diagnostics);
    found.sort_by_key(|diagnostic| diagnostic.labels.first().map(|l| l.span.start()));
    found
}

/// Returns the path of the file that a command names. If the file is missing or must not be read, reports this and returns `None`.
fn named(
    source: &Source,
    name: Span,
    extension: &str,
    folders: &[PathBuf],
    policy: &FilePolicy,
    complaints: &mut Vec<Diagnostic>,
) -> Option<PathBuf> {
    let written = source.text(name);
    let looked_up = find_file(&written, extension, folders);
    let label = |diagnostic: Diagnostic| diagnostic.label(source.name(), name, "");
    complaints.extend(looked_up.diagnostics.into_iter().map(label));
    let Some(path) = looked_up.value else {
        let message = format!("there is no file `{written}`, with or without `.{extension}`");
        let elsewhere = written.contains(':') || written.starts_with(['/', '\\']);
        let mut missing = Diagnostic::error(Code::CannotRead, message);
        if elsewhere {
            // The absolute path may exist on the computer that will run the command file, so this is only a warning.
            missing.severity = Severity::Warning;
        }
        let help =
            "it is searched for in the folder of the command file and in the working directory";
        complaints.push(label(missing.help(help)));
        return None;
    };
    if let Err(mut outside) = policy.check_read(&path) {
        outside.severity = Severity::Note;
        complaints.push(label(outside));
        return None;
    }
    Some(path)
}
