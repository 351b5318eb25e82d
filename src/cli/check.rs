use std::path::PathBuf;

use crate::front::check_page::{Checked, CheckedStudy, check_page};
use admire_report::{Plausibility, Scene};
use admire_session::check;
use admire_session::check::is_command_file;
use admire_study::{Study, missing};
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::lint::Options;
use admire_syntax::property::PropertyFile;
use admire_syntax::text::Source;
use admire_syntax::{CommandFile, Dataset};
use admire_tune::Tuning;

use super::Outcome;
use super::check_settings::{AllSettings, Flags};
use super::input::read_study;
use super::inputs::files_of;
use super::opening::Opening;
use super::output_folder::{Replacing, refuse_replacing, write_folder};
use super::plausibility;
use super::shell::{Exit, Shell, exit_of};

/// Check datasets, command files, files of Adams/Car and studies.
///
/// Prints each message with its place in the file. A command file is checked
/// against the deck that it names. The exit code is 1 if any message is an
/// error; with --strict, also if any message is a warning.
///
/// Comments in a deck silence messages: `! admire: ignore[tab]` after a
/// statement or above it, `! admire: ignore-file[tab]` anywhere for the whole
/// file. Settings for all files of a folder are in `admire.toml` in that folder
/// or in a folder above it:
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
    /// Datasets (.adm), command files (.acf), files of Adams/Car (.sub, .asy, .bus, .spr, .tir, ...), folders, or patterns: `runs/*.adm`. In a
    /// folder with a study.toml, the study is checked, too.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Folder for the page `report.html`. Without this option, no page is written.
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    flags: Flags,
    #[command(flatten)]
    opening: Opening,
    #[command(flatten)]
    replacing: Replacing,
}

const EXAMPLES: &str = "Examples:
  admire check front.adm run.acf
  admire check models --for adams --strict
  admire check models --select undefined-id,duplicate-id --quiet
  admire check models --format sarif > admire.sarif
  admire check models --format github
  admire check my-axle --out pages --open";

/// Checks all files and prints the diagnostics.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    if let Some(out) = &arguments.out {
        refuse_replacing(out, &["report.html"], arguments.replacing, shell)?;
    }
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
            admire_car::check(source)
        } else {
            of_dataset(source, settings.fortran, shell)
        };
        let shown = own.into_iter().filter(|d| settings.shows(d));
        let before = found.len();
        found.extend(shown);
        strict |= settings.strict && found[before..].iter().any(|d| d.severity > Severity::Note);
    }
    let (mut studies, mut steps) = (Vec::new(), Vec::new());
    for folder in &arguments.files {
        if !folder.join("study.toml").is_file() {
            continue;
        }
        let study = Study::read(folder).value;
        let target = match &study {
            Some(study) if study.target.is_some() => Tuning::read(folder).1,
            _ => Vec::new(),
        };
        if let Some(study) = study.filter(Study::is_target_alone) {
            // A study with a target alone needs no readings.
            let deck = study.deck.name().to_string();
            let settings = all.of(&folder.join("study.toml"), shell)?;
            let is_of_deck = |d: &Diagnostic| d.labels.first().is_some_and(|l| *l.file == *deck);
            shell.sources.add(study.source);
            found.extend(
                target
                    .into_iter()
                    .filter(|d| !is_of_deck(d) && settings.shows(d)),
            );
            checked += 1;
            continue;
        }
        let read = read_study(folder, shell);
        match &read.value {
            Some(loaded) => studies.push(CheckedStudy {
                table: Plausibility::of(loaded),
                scene: Scene::of_study(loaded),
            }),
            None => steps.extend(Study::read(folder).value.iter().flat_map(missing)),
        }
        // The diagnostics of the deck itself were printed above, or must not be shown.
        let deck = read
            .value
            .map(|loaded| loaded.study.deck.name().to_string());
        let of_the_deck = |d: &Diagnostic| {
            let file = d.labels.first().map(|label| label.file.to_string());
            file.is_some() && file == deck
        };
        // A missing entry of an unfinished study is not a fault. The list of steps names it.
        let is_step = |d: &Diagnostic| {
            let Some(file) = d.labels.first().map(|label| &label.file) else {
                return false;
            };
            let named = |step: &String| step.starts_with(&format!("{file}:"));
            let is_setting = file.ends_with(".toml");
            steps.iter().any(named) && (!is_setting || d.code == Code::MissingSetting)
        };
        let settings = all.of(&folder.join("study.toml"), shell)?;
        let told = |d: &Diagnostic| !of_the_deck(d) && !is_step(d) && settings.shows(d);
        // Both readings of the study find faults of its settings.
        let of_target = target.into_iter().filter(|d| !read.diagnostics.contains(d));
        let of_target: Vec<Diagnostic> = of_target.collect();
        found.extend(read.diagnostics.into_iter().chain(of_target).filter(told));
        checked += 1;
    }
    shell.findings(&found);
    for study in &studies {
        shell.say(&plausibility::text(&study.table));
    }
    if !steps.is_empty() {
        shell.say("still to fill in, in this order:\n");
        for (at, step) in steps.iter().enumerate() {
            shell.say(&format!("  {}. {step}\n", at + 1));
        }
    }
    if checked > 1 {
        shell.say(&counted(checked, &found));
    }
    if let Some(out) = &arguments.out {
        let page = check_page(&Checked {
            files: &arguments.files,
            found: &found,
            sources: &shell.sources,
            studies: &studies,
            steps: &steps,
        });
        let files = [(PathBuf::from("report.html"), page.into_bytes())];
        write_folder(out, &files, arguments.replacing, shell)?;
        let report = out.join("report.html");
        shell.say(&format!("report: {}\n", report.display()));
        arguments.opening.open(&report, shell);
    }
    let allow_fits = studies.iter().all(|study| study.table.allows_a_fit());
    if !allow_fits || !steps.is_empty() {
        return Err(Exit::Findings);
    }
    if unread || strict {
        return Err(Exit::Findings);
    }
    Ok(exit_of(&found))
}

/// Formats the totals, such as `3 files: 1 error, 2 warnings, 0 notes`.
fn counted(files: usize, found: &[Diagnostic]) -> String {
    let many = |severity: Severity, word: &str| {
        let count = found.iter().filter(|d| d.severity == severity).count();
        super::counted::counted(count, word)
    };
    format!(
        "{files} files: {}, {}, {}\n",
        many(Severity::Error, "error"),
        many(Severity::Warning, "warning"),
        many(Severity::Note, "note")
    )
}

/// Returns all diagnostics of a command file, checked alone and against the decks that it names.
fn of_command_file(source: Source, shell: &mut Shell) -> Vec<Diagnostic> {
    shell.sources.add(source.clone());
    check::command_file(CommandFile::parse(source), |path| {
        let deck = Source::read(path).ok()?;
        Some(Dataset::parse(deck).value)
    })
}

/// Returns all diagnostics of a dataset in the order of the file, each fault only once.
fn of_dataset(source: Source, fortran: bool, shell: &mut Shell) -> Vec<Diagnostic> {
    let read = Dataset::parse(source);
    let files = shell.read_files(&read.value);
    let found = check::dataset(read, files, &Options { fortran }, || false).unwrap_or_default();
    let loud = found.into_iter().filter(|found| !found.silenced);
    loud.map(|found| found.diagnostic).collect()
}
