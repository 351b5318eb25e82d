use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::model::{self, Model};
use crate::session::{FilePolicy, find_file, folder_of};
use crate::syntax::lint::{Options, Suppressed};
use crate::syntax::property::PropertyFile;
use crate::syntax::{self, CommandFile, Dataset};
use crate::text::{Source, Span};

use super::Outcome;
use super::check_settings::{AllSettings, Flags};
use super::inputs::files_of;
use super::shell::{Exit, Shell, exit_of};

/// Check datasets, command files and property files.
///
/// Prints what is wrong with them, each complaint at its place. A command file is checked against the deck it names. Exit code 1 if
/// there is an error among the complaints, with --strict also for warnings.
///
/// Comments of a deck silence complaints: `! admire: ignore[tab]` behind a statement or above it, `! admire: ignore-file[tab]`
/// anywhere for the whole file. Settings for all files of a folder stand in `admire.toml` there or above:
///
/// ```toml
/// [check]
/// for = "adams"                  # or "admire"
/// ignore = ["tab", "unreferenced"]
/// exclude = ["old/**"]
/// strict = true                  # also: select, quiet, fortran
/// ```
#[derive(clap::Args, Debug)]
#[command(verbatim_doc_comment, after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// Datasets (.adm), command files (.acf), property files of Adams/Car (.bus, .spr, ...), folders, or patterns: `runs/*.adm`.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    flags: Flags,
}

const EXAMPLES: &str = "Examples:
  admire check front.adm run.acf
  admire check models --for adams --strict
  admire check models --select undefined-id,duplicate-id --quiet
  admire check models --format sarif > admire.sarif
  admire check models --format github";

/// Prints the complaints about all files.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let mut found: Vec<Diagnostic> = Vec::new();
    let mut unread = false;
    let mut all = AllSettings::new(&arguments.flags);
    let (mut checked, mut strict) = (0, false);
    for path in &files_of(&arguments.files, shell)? {
        let settings = all.of(path, shell)?;
        if !settings.includes(path) {
            continue;
        }
        let Ok(source) = shell.read(path) else {
            unread = true;
            continue;
        };
        checked += 1;
        let own = if is_command_file(path) {
            of_command_file(source, shell)
        } else if PropertyFile::is_one(source.bytes()) {
            PropertyFile::parse(source).diagnostics
        } else {
            of_dataset(source, settings.fortran, shell)
        };
        let shown = own.into_iter().filter(|d| settings.shows(d));
        let before = found.len();
        found.extend(shown);
        strict |= settings.strict && found[before..].iter().any(|d| d.severity > Severity::Note);
    }
    shell.findings(&found);
    if checked > 1 {
        shell.say(&counted(checked, &found));
    }
    if unread || strict {
        return Err(Exit::Findings);
    }
    Ok(exit_of(&found))
}

/// `3 files: 1 error, 2 warnings, 0 notes`.
fn counted(files: usize, found: &[Diagnostic]) -> String {
    let many = |severity: Severity, word: &str| {
        let count = found.iter().filter(|d| d.severity == severity).count();
        let end = if count == 1 { "" } else { "s" };
        format!("{count} {word}{end}")
    };
    format!(
        "{files} files: {}, {}, {}\n",
        many(Severity::Error, "error"),
        many(Severity::Warning, "warning"),
        many(Severity::Note, "note")
    )
}

/// Everything there is to say of a command file: by itself, and against the decks it names.
fn of_command_file(source: Source, shell: &mut Shell) -> Vec<Diagnostic> {
    let commands = CommandFile::parse(source);
    let file = &commands.value;
    let mut found = commands.diagnostics;
    found.extend(syntax::lint::check_commands(file));
    let folder = folder_of(file.source());
    let folders = [folder.clone(), PathBuf::new()];
    let mut policy = FilePolicy::new(Path::new(""));
    policy.allow(&folder);
    policy.confine();
    let mut of_files = Vec::new();
    let sequence = syntax::lint::check_sequence(file, |name| {
        let path = named(file.source(), name, "adm", &folders, &policy, &mut of_files)?;
        let deck = Source::read(&path).ok()?;
        Some(Dataset::parse(deck).value)
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
    shell.sources.add(file.source().clone());
    found
}

/// The file a command names, if it may be read; says why not.
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
            // It may well be on the computer that runs the file.
            missing.severity = Severity::Warning;
        }
        let help = "it is looked up from the folder of the command file and the working directory";
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

/// Everything there is to say of a dataset, each fault once, in the order of the file.
fn of_dataset(source: Source, fortran: bool, shell: &mut Shell) -> Vec<Diagnostic> {
    let read = Dataset::parse(source);
    let dataset = &read.value;
    let files = shell.read_files(dataset);
    let resolved = Model::lower_with(dataset, &files.value);
    let mut found = read.diagnostics;
    found.extend(as_one(files.diagnostics));
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
    let suppressed = Suppressed::of(dataset.source(), dataset.statements());
    found.retain(|diagnostic| !suppressed.covers(diagnostic));
    found.extend(suppressed.diagnostics);
    found.sort_by_key(|diagnostic| diagnostic.labels.first().map(|label| label.span.start()));
    found
}

/// Missing files that change no answer are one note, however many they are: a deck of a CAD model names dozens.
fn as_one(diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let harmless = |d: &Diagnostic| d.code == Code::CannotRead && d.severity == Severity::Note;
    let (notes, mut rest): (Vec<_>, Vec<_>) = diagnostics.into_iter().partition(harmless);
    match notes.len() {
        0 | 1 => rest.extend(notes),
        count => rest.extend(notes.into_iter().next().map(|mut first| {
            first.message =
                format!("{count} files that only graphics or subroutines would read are not here");
            first
        })),
    }
    rest
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
