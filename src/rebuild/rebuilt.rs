use std::path::Path;

use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::text::Span;

use super::deck::{Deck, deck};
use super::mechanism::{Mechanism, mechanism};
use super::record::Record;
use super::repeat_states::{Repeat, repeat};
use super::report::report;
use super::settings::REPEATED_MM;
use super::study::study_files;

/// A mechanism rebuilt from results, as files.
#[derive(Clone, Debug)]
pub struct Rebuilt {
    /// Record of the results.
    pub record: Record,
    /// Mechanism found in the results.
    pub mechanism: Mechanism,
    /// Deck of the mechanism.
    pub deck: Deck,
    /// Agreement of the deck with the results.
    pub repeat: Repeat,
    /// Files of the study folder: name and text.
    pub files: Vec<(String, String)>,
}

/// Rebuilds a deck and a study from results files of one mechanism.
///
/// The files `tests` do not contribute to the deck. Their loads are applied to it, and the resulting poses are compared with the poses in the files.
/// The value is `None` if no mechanism can be found in the files; the diagnostics then contain an error with its place.
pub fn rebuild(paths: &[&Path], tests: &[&Path]) -> Checked<Option<Rebuilt>> {
    let all: Vec<&Path> = paths.iter().chain(tests).copied().collect();
    let read = Record::read(&all);
    let mut diagnostics = read.diagnostics;
    let file = paths
        .first()
        .map(|path| path.display().to_string())
        .unwrap_or_default();
    let refused = |diagnostics: Vec<Diagnostic>| Checked {
        value: None,
        diagnostics,
    };
    let failed = diagnostics
        .iter()
        .any(|found| found.severity == admire_syntax::diagnostic::Severity::Error);
    if failed || read.value.states() == 0 {
        return refused(diagnostics);
    }
    let record = read.value;
    let located = |diagnostic: Diagnostic| diagnostic.label(&*file, Span::at(0), "");
    let found = match mechanism(&record.first_runs(paths.len())) {
        Ok(mut found) => {
            found.take_motions(&record);
            found
        }
        Err(why) => {
            diagnostics.push(located(Diagnostic::error(Code::MissingColumn, why)));
            return refused(diagnostics);
        }
    };
    let names = |list: &[usize], name: &dyn Fn(usize) -> String| {
        list.iter()
            .map(|k| format!("`{}`", name(*k)))
            .collect::<Vec<_>>()
            .join(", ")
    };
    if !found.lost.is_empty() {
        let lost = names(&found.lost, &|k| record.elements[k].name.clone());
        let message =
            format!("the parts of {lost} were not found, so the deck omits these elements");
        let help = "add results of other tests, in which their forces differ";
        diagnostics.push(located(
            Diagnostic::warning(Code::MissingColumn, message).help(help),
        ));
    }
    if !found.bare.is_empty() {
        let bare = names(&found.bare, &|k| record.bodies[k].name.clone());
        let message = format!("no force in the file acts on {bare}");
        let help = "write results without NOREACTIONFORCES and NOAPPLIEDFORCES in RESULTS";
        diagnostics.push(located(
            Diagnostic::warning(Code::MissingColumn, message).help(help),
        ));
    }
    if !found.is_balanced() {
        let message = format!(
            "the moments on the parts balance only to a lever arm of {:.1e} {}: a force is missing or acts at another point",
            found.lever_left, record.units.length.word
        );
        diagnostics.push(located(Diagnostic::warning(Code::MissingColumn, message)));
    }
    let deck = deck(&record, &found);
    let repeated = repeat(&record, &deck);
    let room = REPEATED_MM * 1e-3 / record.units.length.si;
    for run in &record.runs {
        let message = match repeated.largest(run.states.clone()) {
            None => format!(
                "the rebuilt deck has no equilibrium in some states of `{}`",
                run.name
            ),
            Some(apart) if apart > room => format!(
                "the rebuilt deck misses the states of `{}` by up to {apart:.2e} {}, most at `{}`",
                run.name, record.units.length.word, record.bodies[repeated.worst].name
            ),
            Some(_) => continue,
        };
        diagnostics.push(located(Diagnostic::warning(Code::UnreachableCase, message)));
    }
    let mut files = vec![
        ("model.adm".to_string(), deck.text.clone()),
        ("states.acf".to_string(), deck.commands.clone()),
        (
            "rebuild.md".to_string(),
            report(&record, &found, &deck, &repeated),
        ),
    ];
    files.extend(study_files(&record, &found, &deck, "model.adm"));
    Checked {
        value: Some(Rebuilt {
            record,
            mechanism: found,
            deck,
            repeat: repeated,
            files,
        }),
        diagnostics,
    }
}
