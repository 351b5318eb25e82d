use std::path::Path;

use admire_report::{DrawingError, TuneReport};
use admire_results::Timestamp;
use admire_study::digest;
use admire_syntax::text::Source;
use admire_tune::{Outcome, Tuning};

/// Creates the report of a tuning run. `changes` lists the changed lines of the deck.
pub(crate) fn tune_page(
    folder: &Path,
    tuning: &Tuning,
    outcome: &Outcome,
    changes: &str,
) -> Result<String, DrawingError> {
    let deck = tuning
        .study
        .deck_path
        .file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let none = || "none".to_string();
    let listed = |all: Vec<&str>| {
        if all.is_empty() {
            none()
        } else {
            all.join(", ")
        }
    };
    let unknowns = outcome.unknowns.iter().filter(|own| !own.exact_derivatives);
    let goals = outcome.goals.iter().filter(|own| !own.exact_derivatives);
    let differences = unknowns
        .map(|own| own.name.as_str())
        .chain(goals.map(|own| own.name.as_str()));
    let facts = [
        ("Study", folder.display().to_string()),
        ("Tests", tuning.config.as_ref().map_or_else(none, |own| own.source.name().to_string())),
        ("Load cases", if tuning.before.cases.is_empty() { none() } else { tuning.study.loads.source.name().to_string() }),
        (
            "Method",
            "Gauss-Newton with a trust region and active bounds; multipliers for limits and minimax goals".to_string(),
        ),
        (
            "Derivatives by finite differences",
            listed(differences.collect()),
        ),
        (
            "Work",
            format!(
                "evaluations with derivatives: {}, start points: {}, runs of the tests: {}",
                outcome.evaluations,
                outcome.starts.len(),
                outcome.runs
            ),
        ),
        ("Cost function", format!("{:.6} before, {:.6} after", outcome.cost_before, outcome.cost)),
        ("Date", format!("{} UTC", Timestamp::now().date_time())),
        ("Made by", format!("admire {}", admire_report::VERSION)),
        (
            "Inputs",
            format!(
                "SHA-256 {}",
                digest(tuning.study.sources().into_iter().map(Source::bytes))
            ),
        ),
    ];
    let report = TuneReport {
        deck: &deck,
        outcome,
        facts: &facts,
        changes,
    };
    report.page(&format!("admire {}", admire_report::VERSION))
}
