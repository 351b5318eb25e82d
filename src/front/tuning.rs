//! Search for the target of a study, with the effect of the tolerances and a Pareto front of two goals.

use std::path::Path;

use admire_diagnosis::ProgressObserver;
use admire_kc::BenchError;
use admire_report::tune_summary;
use admire_session::Sources;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_tune::{Outcome, Refused, TuneError, Tuning};

use super::error::{Error, ErrorKind};
use super::fit_view::changed_lines;
use super::tune_page;

/// Options of a search for a target.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct TuningOptions {
    /// Number of additional starts within the bounds; `None` for the number that the study states.
    pub restarts: Option<usize>,
    /// Number of axles with drawn tolerances that are solved; `None` for the number that the study states.
    pub draws: Option<usize>,
    /// Two goals whose Pareto front is requested, by name or by number (from 1).
    pub pareto: Option<[String; 2]>,
}

/// Result of a search for a target.
#[derive(Clone, Debug)]
pub struct TuningAnswer {
    /// Contents of `tuning.json`: the changed numbers, the goals that are met, and the conflicts.
    pub json: String,
    /// Result in one or two sentences.
    pub summary: String,
    /// Deck with the tuned numbers.
    pub deck: Vec<u8>,
    /// Report as a complete HTML page.
    pub html: String,
    /// True if the best search converged.
    pub converged: bool,
}

/// Reads the target of a study and runs the search.
pub(super) fn answer(
    folder: &Path,
    options: &TuningOptions,
    watch: &dyn ProgressObserver,
) -> Result<TuningAnswer, Error> {
    let (read, said) = Tuning::read(folder);
    let mut sources = Sources::default();
    if let Ok(tuning) = &read {
        sources.add(tuning.study.source.clone());
        sources.add(tuning.study.deck.clone());
    } else {
        for label in said.iter().flat_map(|found| &found.labels) {
            if sources.get(&label.file).is_none()
                && let Ok(bytes) = std::fs::read(&*label.file)
            {
                sources.add(admire_syntax::text::Source::new(&*label.file, bytes).in_utf8());
            }
        }
    }
    let no_answer = |error: &TuneError| {
        let kind = if is_input(error) {
            ErrorKind::Input
        } else {
            ErrorKind::NoAnswer
        };
        Error::new(kind, &refusal(error), &sources)
    };
    let mut tuning = read.map_err(|refused| match refused {
        Refused::Input => Error::new(ErrorKind::Input, &said, &sources),
        Refused::Start(error) => no_answer(&error),
    })?;
    apply(options, &mut tuning);
    let pair = pair(options, &tuning)
        .map_err(|wrong| Error::new(ErrorKind::Usage, &[*wrong], &sources))?;
    let outcome = tuned(&tuning, pair, watch).map_err(|error| no_answer(&error))?;
    let changes = changed_lines(tuning.dataset.bytes(), &outcome.deck);
    let html = tune_page(folder, &tuning, &outcome, &changes).map_err(|error| {
        let failed = Diagnostic::error(Code::CannotWrite, error.to_string());
        Error::plain(ErrorKind::NoAnswer, &failed)
    })?;
    Ok(TuningAnswer {
        json: json(&outcome),
        summary: tune_summary(&outcome).verdict,
        html,
        converged: outcome.converged,
        deck: outcome.deck,
    })
}

/// Replaces settings of the study by the given options.
pub(crate) fn apply(options: &TuningOptions, tuning: &mut Tuning) {
    let target = &mut tuning.target;
    target.restarts = options.restarts.unwrap_or(target.restarts);
    target.draws = options.draws.unwrap_or(target.draws);
}

/// Returns the indices of the two goals whose Pareto front is requested.
pub(crate) fn pair(
    options: &TuningOptions,
    tuning: &Tuning,
) -> Result<Option<[usize; 2]>, Box<Diagnostic>> {
    let pair = options.pareto.as_ref();
    pair.map(|[first, second]| tuning.pair_named([first, second]))
        .transpose()
}

/// Searches for the target, then for the Pareto front of two goals, and then computes the effect of the tolerances. If the user stops the
/// search, the later steps are left out.
pub(crate) fn tuned(
    tuning: &Tuning,
    pair: Option<[usize; 2]>,
    watch: &dyn ProgressObserver,
) -> Result<Outcome, TuneError> {
    watch.stage("tuning");
    let all = (1 + tuning.target.restarts) * tuning.target.evaluations;
    let (mut before, mut last) = (0, (0, 0));
    let mut outcome = tuning.search(&mut |start, evaluations| {
        if start != last.0 {
            before += last.1;
        }
        last = (start, evaluations);
        watch.count(before + evaluations, Some(all), "evaluations");
        watch.goes_on()
    })?;
    if let Some(pair) = pair.filter(|_| watch.goes_on()) {
        watch.stage("computing the Pareto front");
        let front = tuning.front(&outcome.x, pair, &mut |_, evaluations| {
            watch.count(evaluations, None, "evaluations");
            watch.goes_on()
        });
        outcome.pareto = Some(front);
    }
    if tuning.study.tolerances.is_stated && watch.goes_on() {
        watch.stage("solving axles with drawn tolerances");
        let draws = tuning.target.draws;
        outcome.robust = tuning.robust(&outcome.x, draws, &mut |done| {
            watch.count(done, Some(draws), "axles");
            watch.goes_on()
        });
    }
    Ok(outcome)
}

/// Returns the text of `tuning.json`.
pub(crate) fn json(outcome: &Outcome) -> String {
    serde_json::to_string_pretty(outcome).expect("JSON values print") + "\n"
}

/// Returns true if the error is an error in the deck.
pub(crate) fn is_input(error: &TuneError) -> bool {
    matches!(&error.why, BenchError::Deck(found) if !found.is_empty())
}

/// Returns diagnostics with the reason why there is no result.
pub(crate) fn refusal(error: &TuneError) -> Vec<Diagnostic> {
    let message = match &error.why {
        BenchError::Deck(found) if !found.is_empty() => return found.clone(),
        BenchError::Deck(_) => "the axle has no equilibrium at any start point".to_string(),
        why => why.to_string(),
    };
    let help = "try a smaller range of the test or a smaller load; `admire kc` with the kc.toml of the study shows which test fails";
    vec![Diagnostic::error(Code::NoEquilibrium, message).help(help)]
}
