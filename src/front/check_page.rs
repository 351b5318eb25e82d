//! Page of a check: the faults of files and studies, their places, and the remedies.

use std::path::Path;

use admire_report::{Align, Page, Plausibility, Scene, Table, VERSION, Verdict};
use admire_results::Timestamp;
use admire_session::Sources;
use admire_syntax::diagnostic::{Diagnostic, Severity};

use super::error::Complaint;

/// Study among the checked files.
pub(crate) struct CheckedStudy {
    /// Plausibility of the study's settings, readings and loads.
    pub table: Plausibility,
    /// Model of the study in the design position.
    pub scene: Scene,
}

/// Outcome of a check.
pub(crate) struct Checked<'a> {
    /// Files and folders as the user named them.
    pub files: &'a [std::path::PathBuf],
    /// Diagnostics of all files.
    pub found: &'a [Diagnostic],
    /// Texts of the files.
    pub sources: &'a Sources,
    /// Readable studies among the files.
    pub studies: &'a [CheckedStudy],
    /// Entries that are still missing, in order.
    pub steps: &'a [String],
}

/// Creates the page of a check as HTML text.
pub(crate) fn check_page(checked: &Checked<'_>) -> String {
    let names = checked.files.iter();
    let names: Vec<String> = names.map(|path| path.display().to_string()).collect();
    let mut page = Page::new("Check", &names.join(", "), &answer(checked));
    page.origin(&[
        ("Files", names.join(", ")),
        ("Date", format!("{} UTC", Timestamp::now().date_time())),
        ("Made by", format!("admire {VERSION}")),
    ]);
    page.meaning();
    for study in checked.studies {
        page.scene(&study.scene);
    }
    let doubts = |verdict: Verdict| {
        let lines = checked.studies.iter().flat_map(|study| &study.table.checks);
        let lines = lines.filter(move |line| line.verdict == verdict);
        lines
            .map(|line| format!("{}: {}", line.what, line.why))
            .collect::<Vec<_>>()
    };
    page.found(&[
        ("Implausible", doubts(Verdict::Impossible)),
        ("Doubtful", doubts(Verdict::Doubtful)),
        ("To do next", next(checked)),
    ]);
    if !checked.found.is_empty() {
        page.table(&complaints(checked));
        page.note("`admire explain CODE` explains a code and its remedy.");
    }
    for study in checked.studies {
        page.detail("Plausibility of the study");
        page.table(&plausibility(&study.table));
    }
    page.finish(&format!("admire {VERSION}"))
}

fn count(checked: &Checked<'_>, severity: Severity) -> usize {
    let all = checked.found.iter();
    all.filter(|found| found.severity == severity).count()
}

fn answer(checked: &Checked<'_>) -> String {
    let many = |severity: Severity, word: &str| {
        let count = count(checked, severity);
        let end = if count == 1 { "" } else { "s" };
        (count > 0).then(|| format!("{count} {word}{end}"))
    };
    let counts = [
        many(Severity::Error, "error"),
        many(Severity::Warning, "warning"),
        many(Severity::Note, "note"),
    ];
    let counts: Vec<String> = counts.into_iter().flatten().collect();
    let files = match &counts[..] {
        [] => "No faults were found.".to_string(),
        counts => format!("Found: {}.", counts.join(", ")),
    };
    let allows = checked
        .studies
        .iter()
        .all(|study| study.table.allows_a_fit());
    let study = match checked.studies {
        _ if !checked.steps.is_empty() => " The study is incomplete.",
        [] => "",
        _ if allows => " The study is plausible enough for a fit.",
        _ => " The study is implausible and should not be fitted.",
    };
    files + study
}

fn next(checked: &Checked<'_>) -> Vec<String> {
    if !checked.steps.is_empty() {
        return checked.steps.to_vec();
    }
    if count(checked, Severity::Error) > 0 {
        return vec![
            "Correct the errors, beginning with the first: later ones often follow from it"
                .to_string(),
        ];
    }
    if checked
        .studies
        .iter()
        .any(|study| !study.table.allows_a_fit())
    {
        return vec!["Correct the implausible entries".to_string()];
    }
    match checked.studies {
        [] => Vec::new(),
        _ => vec!["Run `admire identify` or `admire diagnose` on the study".to_string()],
    }
}

/// Tabulates the diagnostics, errors first.
fn complaints(checked: &Checked<'_>) -> Table {
    let mut all: Vec<Complaint> = checked
        .found
        .iter()
        .map(|found| Complaint::new(found, checked.sources))
        .collect();
    all.sort_by_key(|complaint| std::cmp::Reverse(complaint.severity));
    let mut table = Table::new(&[
        ("severity", Align::Left),
        ("place", Align::Left),
        ("message", Align::Wrap),
        ("code", Align::Left),
        ("remedy", Align::Wrap),
    ]);
    for complaint in all {
        let (word, class) = match complaint.severity {
            Severity::Error => ("error", "bad"),
            Severity::Warning => ("warning", ""),
            Severity::Note => ("note", "soft"),
        };
        let place = complaint.places.first().map(|place| {
            let file = Path::new(&place.file).file_name().unwrap_or_default();
            let file = file.to_string_lossy();
            match place.line {
                Some(line) => format!("{file}:{line}"),
                None => file.into_owned(),
            }
        });
        table.row([
            word.to_string(),
            place.unwrap_or_default(),
            complaint.message,
            complaint.code.to_string(),
            complaint.help.unwrap_or_default(),
        ]);
        table.mark(0, class);
    }
    table
}

/// Tabulates the properties of a study, with the assessment of each.
fn plausibility(found: &Plausibility) -> Table {
    let mut table = Table::new(&[
        ("verdict", Align::Left),
        ("property", Align::Left),
        ("found", Align::Wrap),
        ("reason for the verdict", Align::Wrap),
    ]);
    for check in &found.checks {
        let (word, class) = match check.verdict {
            Verdict::Plausible => ("ok", "good"),
            Verdict::Doubtful => ("warn", ""),
            Verdict::Impossible => ("fail", "bad"),
        };
        table.row([word, check.what, &check.found, &check.why]);
        table.mark(0, class);
    }
    table
}
