//! Plausibility table, shown before every fit. An implausible study is not fitted.

use std::path::Path;

use comfy_table::{ContentArrangement, Table, presets};

use admire_identify::LoadedStudy;
use admire_report::{Plausibility, Verdict};
use admire_solver::model::lint;
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::shell::{Exit, Shell};
use super::width::table_text;

/// Checks the plausibility of a study. A verbose command prints the whole table; otherwise one line names the doubtful properties. An
/// implausible study ends the command with the whole table unless `force` is set.
pub(super) fn before_a_fit(loaded: &LoadedStudy, force: bool, shell: &Shell) -> Result<(), Exit> {
    let found = Plausibility::of(loaded);
    let refusal = found.refusal();
    if shell.is_verbose() || refusal.is_some() {
        shell.say(&text(&found));
    } else if let Some(line) = doubts(&found, &loaded.study.folder) {
        shell.say(&line);
    }
    let Some(message) = refusal else {
        return Ok(());
    };
    if force {
        shell.complain(&[Diagnostic::warning(Code::ImplausibleStudy, message)]);
        return Ok(());
    }
    deck_warnings(loaded, shell);
    Err(shell.fail(
        Diagnostic::error(Code::ImplausibleStudy, message).help("--force fits the study anyway"),
    ))
}

/// Names the doubtful properties of a study in one line; `None` if there are none.
fn doubts(found: &Plausibility, study: &Path) -> Option<String> {
    let doubtful = found.checks.iter();
    let doubtful = doubtful.filter(|check| check.verdict == Verdict::Doubtful);
    let mut names: Vec<&str> = doubtful.map(|check| check.what).collect();
    names.dedup();
    (!names.is_empty()).then(|| {
        let names = names.join(", ");
        format!(
            "doubtful properties of the study: {names}; see `admire check {}`\n",
            study.display()
        )
    })
}

/// Prints the lint warnings of a study's deck after its fit has failed, because they may name the reason.
pub(super) fn deck_warnings(loaded: &LoadedStudy, shell: &Shell) {
    shell.complain(&lint::check(&loaded.dataset, &loaded.model));
}

/// Formats the plausibility table for a terminal.
pub(super) fn text(found: &Plausibility) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(80);
    for check in &found.checks {
        let word = match check.verdict {
            Verdict::Plausible => "ok",
            Verdict::Doubtful => "warn",
            Verdict::Impossible => "fail",
        };
        let told = if check.why.is_empty() {
            check.found.clone()
        } else {
            format!("{}\n-> {}", check.found, check.why)
        };
        table.add_row([word, check.what, &told]);
    }
    table_text(&table) + "\n"
}
