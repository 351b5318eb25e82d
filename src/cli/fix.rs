use std::path::{Path, PathBuf};

use similar::TextDiff;

use admire_session::check::is_command_file;
use admire_solver::model::replace_user_forces;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::files::references;
use admire_syntax::lint::{self, Options};
use admire_syntax::text::{Source, Span, apply_edits};
use admire_syntax::{CommandFile, Dataset, all_fixes, safe_fixes};

use super::Outcome;
use super::get;
use super::inputs::files_of;
use super::shell::{Exit, Shell};

/// Apply fixes that keep the meaning of a dataset or a command file.
///
/// Shows the changes; with --write, also makes them.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// Datasets (.adm), command files (.acf), folders, or patterns: `runs/*.adm`.
    #[arg(required = true)]
    decks: Vec<PathBuf>,
    /// Also apply fixes that may be wrong: a misspelt word is replaced by the only similar word, and a missing comma at the end of a line is added.
    #[arg(long = "unsafe")]
    may_be_wrong: bool,
    /// Write the changes to the files. Without this option, they are only shown.
    #[arg(long)]
    write: bool,
    /// Also replace forces by USER subroutines that only read an Adams/Car bushing, spring or bump-stop file. The new forces contain the curves of
    /// the file.
    #[arg(long)]
    replace_user: bool,
    /// With --replace-user: folder in which property files are searched by name, besides the folder of the deck.
    #[arg(long, value_name = "FOLDER", requires = "replace_user")]
    files: Vec<PathBuf>,
    /// With --replace-user: free length of a spring, or distance at which a stop makes contact, in the length unit of the deck: `SFORCE/3=210`.
    #[arg(long, value_name = "FORCE=LENGTH", requires = "replace_user")]
    length: Vec<String>,
    /// With --replace-user: force, such as `GFORCE/3`, whose subroutine depends only on its property file; the other USER parameters are
    /// ignored.
    #[arg(long, value_name = "FORCE", requires = "replace_user")]
    plain: Vec<String>,
}

/// Shows the changes, and with --write applies them.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let mut exit = Exit::Fine;
    for path in &files_of(&arguments.decks, shell)? {
        let Ok(source) = shell.read_for(path, arguments.write) else {
            exit = Exit::Findings;
            continue;
        };
        let mut fixed = fixed(&source, is_command_file(path), arguments.may_be_wrong);
        if arguments.replace_user && !is_command_file(path) {
            let safe = Source::new(source.name(), fixed);
            fixed = without_user_forces(&safe, arguments, shell)?;
        }
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

const EXAMPLES: &str = "Examples:
  admire fix front.adm                    show what would change
  admire fix front.adm --write            change it
  admire fix models --unsafe              misspelt keywords, too";

/// Applies all fixes that do not overlap. Fixing is repeated in rounds, because a corrected word may reveal further faults.
fn fixed(source: &Source, is_command_file: bool, may_be_wrong: bool) -> Vec<u8> {
    const ROUNDS: usize = 10;
    let mut source = source.clone();
    for _ in 0..ROUNDS {
        let found = if is_command_file {
            CommandFile::parse(source.clone()).diagnostics
        } else {
            let parsed = Dataset::parse(source.clone());
            let mut found = parsed.diagnostics;
            found.extend(lint::check(&parsed.value, &Options::default()));
            found
        };
        let edits = if may_be_wrong {
            all_fixes(&found, source.name())
        } else {
            safe_fixes(&found, source.name())
        };
        // If the edits conflict, the file is left unchanged.
        match apply_edits(source.bytes(), &edits) {
            Ok(bytes) if !edits.is_empty() => source = Source::new(source.name(), bytes),
            _ => break,
        }
    }
    source.bytes().to_vec()
}

/// Replaces forces whose subroutines read property files. The new forces contain the curves of these files.
fn without_user_forces(
    source: &Source,
    arguments: &Arguments,
    shell: &mut Shell,
) -> Result<Vec<u8>, Exit> {
    let dataset = Dataset::parse(source.clone()).value;
    let mut lengths = Vec::new();
    for text in &arguments.length {
        let (word, value) = text.split_once('=').unwrap_or((text, ""));
        let address = get::parse(word, &dataset, shell)?;
        let Ok(value) = value.trim().parse::<f64>() else {
            let message = format!("`{text}` does not have the form FORCE=LENGTH");
            let wrong = Diagnostic::error(Code::BadNumber, message);
            return Err(shell.usage(wrong.help("write a force and a number, such as SFORCE/3=210")));
        };
        lengths.push((address, value));
    }
    let mut plain = Vec::new();
    for text in &arguments.plain {
        plain.push(get::parse(text, &dataset, shell)?);
    }
    let mut files = shell.read_files(&dataset).value;
    for reference in references(&dataset) {
        if files.get(&reference.name).is_none() {
            let found = arguments
                .files
                .iter()
                .find_map(|f| below(f, &reference.name));
            if let Some(found) = found {
                files.add(reference.name, shell.read(&found)?);
            }
        }
    }
    let replacement = replace_user_forces(&dataset, &files, &lengths, &plain);
    shell.complain(&replacement.diagnostics);
    Ok(apply_edits(source.bytes(), &replacement.edits).unwrap_or_else(|_| source.bytes().to_vec()))
}

/// Finds a file below a folder by its name in the Adams/Car database, such as `mdids://acar/bushings.tbl/a.bus`. Only the last part of the
/// name is compared, regardless of case.
fn below(folder: &Path, name: &str) -> Option<PathBuf> {
    let last = name.rsplit(['/', '\\']).next()?;
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        let mut entries: Vec<PathBuf> = std::fs::read_dir(folder)
            .into_iter()
            .flatten()
            .flatten()
            .map(|entry| entry.path())
            .collect();
        entries.sort();
        for path in entries {
            let own = path.file_name().map(|n| n.to_string_lossy().into_owned());
            if path.is_symlink() {
                continue;
            }
            if path.is_dir() {
                open.push(path);
            } else if own.is_some_and(|own| own.eq_ignore_ascii_case(last)) {
                return Some(path);
            }
        }
    }
    None
}

/// Formats the change of a file as a unified diff.
pub(super) fn diff(source: &Source, fixed: &[u8]) -> String {
    let text = |source: &Source| source.text(Span::new(0, source.bytes().len())).into_owned();
    let before = text(source);
    let after = text(&Source::new(source.name(), fixed));
    TextDiff::from_lines(&before, &after)
        .unified_diff()
        .header(source.name(), &format!("{} (changed)", source.name()))
        .to_string()
}
