//! Tests of every lint code on a deck of its own, and of false alarms on real decks.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use admire_solver::model;
use admire_solver::model::Model;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::lint::{self, Options, RULES};
use admire_syntax::text::Source;

use crate::common::{files_below, shared};

/// Returns the diagnostics of the reader, the lint rules and the model rules. The rule that is off by default is enabled for its own deck
/// only.
fn findings(path: &Path) -> (Dataset, Vec<Diagnostic>) {
    let name = path
        .file_name()
        .expect("a name")
        .to_string_lossy()
        .to_string();
    let options = Options {
        fortran: name == "line-too-long.adm",
    };
    let bytes = std::fs::read(path).expect("readable deck");
    let read = Dataset::parse(Source::new(name, bytes));
    let mut found = read.diagnostics;
    found.extend(lint::check(&read.value, &options));
    let resolved = Model::lower(&read.value);
    found.extend(model::lint::check(&read.value, &resolved.value));
    (read.value, found)
}

/// Formats a diagnostic for a snapshot: severity, code, message, labelled positions and text, help, and fix.
fn shown(dataset: &Dataset, diagnostic: &Diagnostic) -> String {
    let source = dataset.source();
    let severity = match diagnostic.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Note => "note",
    };
    let mut out = format!("{severity}[{}] {}\n", diagnostic.code, diagnostic.message);
    for label in &diagnostic.labels {
        let at = source.line_column(label.span.start());
        let text = source
            .text(label.span)
            .replace('\n', "\\n")
            .replace('\t', "\\t");
        let _ = writeln!(
            out,
            "  {}:{} `{text}` {}",
            at.line, at.column, label.message
        );
    }
    if let Some(help) = &diagnostic.help {
        let _ = writeln!(out, "  help: {help}");
    }
    if let Some(fix) = &diagnostic.fix {
        let _ = writeln!(out, "  fix: {} ({} edits)", fix.title, fix.edits.len());
    }
    out
}

#[test]
fn each_code_has_a_deck_that_shows_it() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/lint");
    let mut seen = Vec::new();
    for path in files_below(&folder, "adm") {
        let stem = path
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .to_string();
        let (dataset, found) = findings(&path);
        assert!(
            found
                .iter()
                .any(|diagnostic| diagnostic.code.as_str() == stem),
            "{stem}.adm does not show {stem}: {found:?}"
        );
        let text: String = found.iter().map(|d| shown(&dataset, d)).collect();
        insta::assert_snapshot!(format!("lint_{stem}"), text);
        seen.push(stem);
    }
    let of_reader = [
        Code::UnknownStatement,
        Code::UnknownArgument,
        Code::AmbiguousKeyword,
        Code::SyntaxError,
        Code::BadNumber,
        Code::BadExpression,
        Code::MissingEnd,
        Code::InactiveInStatics,
        Code::NotSolvedInStatics,
        Code::UserSubroutine,
    ];
    let of_model = [
        Code::BushingAngle,
        Code::JointNotAligned,
        Code::ImplausibleUnits,
        Code::LostTorque,
    ];
    for code in RULES
        .iter()
        .map(|rule| rule.code)
        .chain(of_reader)
        .chain(of_model)
    {
        assert!(
            seen.iter().any(|stem| stem == code.as_str()),
            "corpus/lint/{code}.adm is missing"
        );
    }
}

/// Checks the number of diagnostics for each real deck and code against a reviewed list, which gives the reason for each entry.
#[test]
fn real_decks_show_only_what_was_reviewed() {
    let Some(folder) = shared("real-decks") else {
        return;
    };
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut examples: BTreeMap<String, String> = BTreeMap::new();
    for path in files_below(&folder, "adm") {
        let deck = path
            .strip_prefix(&folder)
            .expect("below")
            .to_string_lossy()
            .replace('\\', "/");
        let (dataset, found) = findings(&path);
        for diagnostic in found {
            let key = format!("{deck} {}", diagnostic.code);
            *counts.entry(key.clone()).or_default() += 1;
            examples
                .entry(key)
                .or_insert_with(|| shown(&dataset, &diagnostic));
        }
    }
    let reviewed: BTreeMap<String, usize> = include_str!("real_deck_findings.txt")
        .lines()
        .filter(|line| !line.starts_with('#') && !line.trim().is_empty())
        .map(|line| {
            let (key, reason) = line.split_once(" | ").expect("deck code count | reason");
            assert!(reason.len() > 10, "no reason: {line}");
            let (key, count) = key.trim().rsplit_once(' ').expect("deck code count");
            (key.trim().to_string(), count.parse().expect("a count"))
        })
        .collect();
    let mut wrong = String::new();
    for (key, count) in &counts {
        if reviewed.get(key) != Some(count) {
            let _ = write!(wrong, "{key} {count}\n{}", examples[key]);
        }
    }
    for key in reviewed.keys().filter(|key| !counts.contains_key(*key)) {
        let _ = writeln!(wrong, "{key}: no longer found");
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Checks that the misaligned joints and their distances agree with ADAMS, which warns that their markers "are not initially coincident".
/// The warning prints the distance to four decimals.
#[test]
fn joints_apart_are_those_adams_warns_of() {
    let Some(folder) = shared("real-decks/adamspy-feed") else {
        return;
    };
    let (_, found) = findings(&folder.join("FRS5_doe_8_LAUL_analysis.adm"));
    let ours: Vec<&str> = found
        .iter()
        .filter(|diagnostic| diagnostic.code == Code::JointNotAligned)
        .map(|diagnostic| diagnostic.message.as_str())
        .collect();
    let bytes = std::fs::read(folder.join("FRS5_doe_8_LAUL_analysis.msg")).expect("readable");
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let mut theirs = 0;
    for warning in text.split("The markers for model.").skip(1) {
        let name = warning.split_whitespace().next().expect("a name");
        let line = warning
            .lines()
            .find(|line| line.contains("Delta X"))
            .expect("the distance");
        let squares = line
            .split('=')
            .skip(1)
            .filter_map(|piece| piece.split_whitespace().next())
            .map(|word| word.trim_end_matches('.').parse::<f64>().expect("a number"))
            .map(|delta| delta * delta);
        let distance = squares.sum::<f64>().sqrt();
        let complaint = ours
            .iter()
            .find(|message| message.contains(&format!("({name})")))
            .unwrap_or_else(|| panic!("{name} is not reported: {ours:?}"));
        let shown = complaint.split("I is ").nth(1).expect("a distance");
        let shown: f64 = shown
            .split(' ')
            .next()
            .expect("a word")
            .parse()
            .expect("a number");
        assert!(
            (shown - distance).abs() < 2e-4,
            "{name}: {shown} and {distance}"
        );
        theirs += 1;
    }
    assert_eq!((ours.len(), theirs), (5, 5));
}

/// Checks that the decks of the project and of the reference have no diagnostic more severe than a note.
#[test]
fn shipped_and_reference_decks_are_clean() {
    let mut folders = vec![
        Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson"),
        Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/multilink"),
    ];
    folders.extend(shared("reference"));
    for path in folders.iter().flat_map(|folder| files_below(folder, "adm")) {
        let (dataset, found) = findings(&path);
        let bad: String = found
            .iter()
            .filter(|diagnostic| diagnostic.severity > Severity::Note)
            .map(|diagnostic| shown(&dataset, diagnostic))
            .collect();
        assert!(bad.is_empty(), "{}:\n{bad}", path.display());
    }
}
