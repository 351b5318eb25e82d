use std::collections::BTreeSet;

use admire_solver::model;
use admire_solver::model::Model;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::files::Files;
use admire_syntax::lint::{Options, Reach, Suppressed, check_until};

/// The part of the program that found a problem.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum DiagnosticSource {
    /// The parser of the text.
    Reader,
    /// A lint rule that reads only a statement and its neighbours.
    Neighbourhood,
    /// A check of the whole file: lint rules, files that it names, or the model.
    File,
}

/// A diagnostic, with the part of the program that reported it.
#[derive(Clone, Debug)]
pub struct Found {
    /// Part of the program that reported the diagnostic.
    pub told: DiagnosticSource,
    /// The diagnostic.
    pub diagnostic: Diagnostic,
    /// True if a comment in the file suppresses the diagnostic.
    pub silenced: bool,
}

impl Found {
    /// Creates a finding that is not suppressed by a comment.
    pub fn new(told: DiagnosticSource, diagnostic: Diagnostic) -> Self {
        Self {
            told,
            diagnostic,
            silenced: false,
        }
    }
}

/// Checks a dataset and returns all findings in the order of the file; each problem is reported once. `files` are the files that the
/// dataset names.
///
/// `outdated` is called between the checks. As soon as it returns true, the result is `None`.
pub fn dataset(
    read: Checked<Dataset>,
    files: Checked<Files>,
    options: &Options,
    outdated: impl Fn() -> bool,
) -> Option<Vec<Found>> {
    let dataset = &read.value;
    let of = |told| move |diagnostic| Found::new(told, diagnostic);
    let resolved = Model::lower_with(dataset, &files.value);
    let mut found: Vec<Found> = read
        .diagnostics
        .into_iter()
        .map(of(DiagnosticSource::Reader))
        .collect();
    found.extend(
        as_one(files.diagnostics)
            .into_iter()
            .map(of(DiagnosticSource::File)),
    );
    let linted = check_until(dataset, options, Reach::File, &outdated)?;
    found.extend(linted.into_iter().map(|(reach, diagnostic)| {
        let told = match reach {
            Reach::Statement | Reach::Neighbours => DiagnosticSource::Neighbourhood,
            Reach::File => DiagnosticSource::File,
        };
        Found::new(told, diagnostic)
    }));
    let seen: BTreeSet<_> = found.iter().map(|found| place(&found.diagnostic)).collect();
    let mut own = BTreeSet::new();
    let groundless = found.iter().any(|f| f.diagnostic.code == Code::NoGround);
    // The conversion to a model may report faults of statements that were already reported.
    for diagnostic in resolved.diagnostics {
        let whole = diagnostic.labels.first().map(|label| label.span);
        let new = !seen.contains(&place(&diagnostic)) && own.insert((diagnostic.code, whole));
        if new && !(groundless && diagnostic.code == Code::NoGround) {
            found.push(of(DiagnosticSource::File)(diagnostic));
        }
    }
    if outdated() {
        return None;
    }
    let of_model = model::lint::check(dataset, &resolved.value);
    found.extend(of_model.into_iter().map(of(DiagnosticSource::File)));
    let suppressed = Suppressed::of(dataset.source(), dataset.statements());
    for found in &mut found {
        found.silenced = suppressed.covers(&found.diagnostic);
    }
    found.extend(
        suppressed
            .diagnostics
            .into_iter()
            .map(of(DiagnosticSource::Neighbourhood)),
    );
    found.sort_by_key(|found| {
        let label = found.diagnostic.labels.first();
        label.map(|label| label.span.start())
    });
    Some(found)
}

/// Merges all notes about harmless missing files into one note, because the deck of a CAD model names dozens of such files.
fn as_one(diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let harmless = |d: &Diagnostic| d.code == Code::CannotRead && d.severity == Severity::Note;
    let (notes, mut rest): (Vec<_>, Vec<_>) = diagnostics.into_iter().partition(harmless);
    match notes.len() {
        0 | 1 => rest.extend(notes),
        count => rest.extend(notes.into_iter().next().map(|mut first| {
            first.message =
                format!("{count} files that only graphics or subroutines would read do not exist");
            first
        })),
    }
    rest
}

/// Returns the code and the start offset of a diagnostic, by which duplicates are recognised. The end of the span is not compared, because
/// two diagnostics about the same problem may have spans of different length.
fn place(diagnostic: &Diagnostic) -> (Code, Option<usize>) {
    let label = diagnostic.labels.first();
    (diagnostic.code, label.map(|label| label.span.start()))
}
