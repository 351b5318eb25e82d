//! Which hypotheses go into the model: forward and backward, every step refitted jointly.

use std::sync::Arc;

use rayon::prelude::*;

use super::cause::Cause;
use super::effort::Effort;
use super::exchange::exchanged;
use super::extended::{Fitted, Warm, fit};
use super::hypothesis::Hypothesis;
use super::influence::Influence;
use super::screening::{Score, penalty, screen};
use super::subject::{Data, Subject};
use crate::identify::global::gauss_newton::Ending;

/// Rivals whose criterion is within so much of the best one's cannot be told apart.
pub const RIVAL: f64 = 6.0;
/// Candidates this close are fitted to the end before they are compared.
const CLOSE: f64 = 60.0;
/// A free-form cause has to do better by so much than any other.
const FREE_FORM: f64 = 6.0;
/// The law of friction, of a stop, of a rubber's progression is known to about a tenth; the square of that is left in chi-square.
const ROUGH: f64 = 0.01;
/// What promises less than this part of the best is not refitted.
pub(super) const HOPELESS: f64 = 0.2;
/// What gains more than this needs no cross-validation: a single case may be all that shows it, as a stop that is met once.
const SURE: f64 = 60.0;
/// Places that are refitted in each step.
const SURVIVORS: usize = 8;
/// Rivals may take another's place so often,
const SWAPS: usize = 4;
/// where they do better by so much: two names of the same thing would take turns.
pub(super) const BETTER: f64 = 0.1;
/// A hypothesis makes way for another and a companion so often.
const EXCHANGES: usize = 2;
/// Causes at most.
pub(super) const MOST: usize = 4;

/// A rival of a finding.
#[derive(Clone, Debug)]
pub struct Rival {
    /// What.
    pub cause: Cause,
    /// Where.
    pub address: String,
    /// By how much its criterion is behind, after its own refit.
    pub behind: f64,
    /// The fit with it instead, and what it is there; of the closest rival only.
    pub instead: Option<(Arc<Fitted>, Hypothesis)>,
}

/// A model and its criterion.
#[derive(Debug)]
pub struct Selected {
    /// The fit.
    pub fitted: Fitted,
    /// How many hypotheses were tried.
    pub places: usize,
    /// Chi-square without each chosen hypothesis less that with all.
    pub gains: Vec<f64>,
    /// Rivals of each chosen hypothesis.
    pub rivals: Vec<Vec<Rival>>,
    /// What each cause gained when it came in.
    pub gained: Gained,
}

/// What causes gained when they came into a model.
pub type Gained = Vec<(Hypothesis, f64)>;

/// Chi-square plus the penalties of what is in a fit.
pub fn criterion(fitted: &Fitted, places: usize) -> f64 {
    let covariance = fitted.covariance();
    let rows: f64 = fitted.weights.iter().sum();
    let mut value = fitted.chi_square();
    for (chosen, place) in fitted.chosen.iter().zip(&fitted.places) {
        let known: f64 = place
            .iter()
            .map(|&at| {
                let sd = fitted.priors[at].sd;
                1.0 - (covariance[(at, at)] / (sd * sd)).min(1.0)
            })
            .sum();
        value += penalty(known, rows, places);
        if chosen.cause.is_free_form() {
            value += FREE_FORM;
        }
    }
    value
}

/// The chosen hypotheses of a fit with first guesses, which its own values replace.
fn chosen(fitted: &Fitted) -> Vec<(Hypothesis, Vec<f64>)> {
    fitted
        .chosen
        .iter()
        .map(|h| (h.clone(), vec![0.0; h.numbers.len()]))
        .collect()
}

/// One form per place, best first, at least promising `least`.
pub(super) fn survivors(
    scores: Vec<Score>,
    least: f64,
    accept: &dyn Fn(&Hypothesis) -> bool,
) -> Vec<Score> {
    let mut out: Vec<Score> = Vec::new();
    for score in scores {
        let double = out
            .iter()
            .any(|s| s.hypothesis.same_place(&score.hypothesis));
        if score.net > least && !double && accept(&score.hypothesis) {
            out.push(score);
        }
        if out.len() == SURVIVORS {
            break;
        }
    }
    out
}

/// Fits `fitted` with one more hypothesis.
pub(super) fn with(
    (subject, data): (&Subject<'_>, Data),
    fitted: &Fitted,
    score: &Score,
    effort: Effort,
) -> Option<Fitted> {
    let mut all = chosen(fitted);
    all.push((score.hypothesis.clone(), score.estimate.clone()));
    let warm = Warm {
        fitted,
        step: &score.step,
    };
    let found = fit(subject, &all, Some(warm), data, effort)
        .or_else(|| fit(subject, &all, Some(Warm::at(fitted)), data, effort))?;
    let last = found.chosen.len() - 1;
    (!found.has_wrong_sign(last)).then_some(found)
}

/// Refits of all that survived, in their order. The first says what can be reached; the others are given up where they stay far from
/// that, or from `reached`.
fn refits(
    subject: &Subject<'_>,
    base: &Fitted,
    scores: &[Score],
    data: Data,
    reached: f64,
) -> Vec<Option<Fitted>> {
    let Some((first, others)) = scores.split_first() else {
        return Vec::new();
    };
    let first = with((subject, data), base, first, Effort::candidate(reached));
    let reached = first
        .as_ref()
        .map_or(reached, |first| first.minimum.objective.min(reached));
    let mut out = vec![first];
    out.par_extend(
        others
            .par_iter()
            .map(|score| with((subject, data), base, score, Effort::candidate(reached))),
    );
    // Where the first steps were hard the order may still change.
    let objectives = out.iter().flatten().map(|found| found.minimum.objective);
    let best = objectives.fold(f64::INFINITY, f64::min);
    out.into_par_iter()
        .map(|found| {
            let found = found?;
            let close = found.minimum.objective < 3.0 * best;
            let unfinished = found.minimum.ending == Ending::MaxIterations;
            Some(if close && unfinished {
                polished(subject, found, data)
            } else {
                found
            })
        })
        .collect()
}

/// Fits a rival in the place of a chosen hypothesis, from where the chosen one has brought the other unknowns: what is the same thing in
/// other words is there at once.
fn in_place_of(
    subject: &Subject<'_>,
    (current, at): (&Fitted, usize),
    score: &Score,
    data: Data,
) -> Option<Fitted> {
    let mut all = chosen(current);
    all.remove(at);
    all.push((score.hypothesis.clone(), score.estimate.clone()));
    let effort = Effort::candidate(current.minimum.objective);
    let found = fit(subject, &all, Some(Warm::at(current)), data, effort)?;
    let last = found.chosen.len() - 1;
    (!found.has_wrong_sign(last)).then_some(found)
}

/// The same model, fitted as well as it can be.
pub(super) fn polished(subject: &Subject<'_>, found: Fitted, data: Data) -> Fitted {
    let again = fit(
        subject,
        &chosen(&found),
        Some(Warm::at(&found)),
        data,
        Effort::FULL,
    );
    again.unwrap_or(found)
}

/// Fits `fitted` without one of its hypotheses.
pub(super) fn without(
    subject: &Subject<'_>,
    fitted: &Fitted,
    at: usize,
    data: Data,
    effort: Effort,
) -> Option<Fitted> {
    let mut all = chosen(fitted);
    all.remove(at);
    fit(subject, &all, Some(Warm::at(fitted)), data, effort)
}

/// What a further cause has to gain beside those whose law is only roughly known: so much of chi-square may be the law's own error.
pub(super) fn floor(gained: &[(Hypothesis, f64)], hypothesis: &Hypothesis) -> f64 {
    if hypothesis.cause == Cause::MarkOutlier {
        return 0.0;
    }
    gained
        .iter()
        .filter(|(h, _)| h.cause.has_rough_law() && !h.same_place(hypothesis))
        .map(|(_, gain)| ROUGH * gain)
        .fold(0.0, f64::max)
}

/// Adds and drops hypotheses until nothing gains, starting from a fit. `accept` limits which may be added; only with `compare` is
/// each one held against its rivals, which takes most of the time.
pub fn select(
    subject: &Subject<'_>,
    (start, mut gained): (Fitted, Gained),
    data: Data,
    accept: &dyn Fn(&Hypothesis) -> bool,
    compare: bool,
) -> Selected {
    let first = screen(subject, &start);
    let places = first.len() + start.chosen.len();
    let mut current = start;
    let mut best = criterion(&current, places);
    let mut scores = first;
    while current.chosen.len() < MOST && !subject.budget.is_spent() {
        let promise = scores.first().map_or(0.0, |score| HOPELESS * score.net);
        // A score may promise too little, but not by much.
        let tried = survivors(scores, promise.max(0.0), &|h| accept(h))
            .into_iter()
            .filter(|score| score.net > 0.3 * floor(&gained, &score.hypothesis))
            .collect::<Vec<_>>();
        let mut winner: Option<(Fitted, f64)> = None;
        for found in refits(subject, &current, &tried, data, current.minimum.objective)
            .into_iter()
            .flatten()
        {
            let value = criterion(&found, places);
            let last = found.chosen.len() - 1;
            let enough = best - value > floor(&gained, &found.chosen[last]);
            if enough && value < winner.as_ref().map_or(best, |(_, best)| *best) {
                winner = Some((found, value));
            }
        }
        let Some((found, value)) = winner else { break };
        gained.push((found.chosen[found.chosen.len() - 1].clone(), best - value));
        current = polished(subject, found, data);
        best = value.min(criterion(&current, places));
        // A mimic goes again when the true cause is in.
        (current, best) = pruned(subject, (current, best), places, data);
        scores = screen(subject, &current);
    }
    for _ in 0..EXCHANGES {
        let Some(found) = exchanged(subject, (&current, best), places, (data, &gained), accept)
        else {
            break;
        };
        (current, best) = pruned(subject, found, places, data);
        // What the causes gained when they came in was said of others.
        gained.retain(|(h, _)| current.chosen.iter().any(|chosen| chosen.same(h)));
        let all = current.chosen.clone();
        for (at, hypothesis) in all.iter().enumerate() {
            if hypothesis.cause.has_rough_law() && !gained.iter().any(|(h, _)| h.same(hypothesis)) {
                let effort = Effort::candidate(current.minimum.objective);
                if let Some(base) = without(subject, &current, at, data, effort) {
                    gained.push((hypothesis.clone(), criterion(&base, places) - best));
                }
            }
        }
    }
    if !compare {
        let count = current.chosen.len();
        return Selected {
            fitted: current,
            places,
            gains: vec![0.0; count],
            rivals: vec![Vec::new(); count],
            gained,
        };
    }
    let mut selected = finish(subject, current, (best, places), data, accept);
    selected.gained = gained;
    selected
}

/// Drops what the other hypotheses of a fit make needless; the last one in stays.
fn pruned(
    subject: &Subject<'_>,
    (mut current, mut best): (Fitted, f64),
    places: usize,
    data: Data,
) -> (Fitted, f64) {
    let mut at = 0;
    while current.chosen.len() > 1 && at + 1 < current.chosen.len() {
        let effort = Effort::candidate(current.minimum.objective);
        if let Some(found) = without(subject, &current, at, data, effort) {
            let value = criterion(&found, places);
            if value < best {
                current = polished(subject, found, data);
                best = value.min(criterion(&current, places));
                continue;
            }
        }
        at += 1;
    }
    (current, best)
}

/// How badly each case is predicted by all others: cross-validation over load cases.
fn predicted(subject: &Subject<'_>, fitted: &Fitted) -> f64 {
    let mut cases: Vec<Vec<usize>> = vec![Vec::new(); fitted.states.len()];
    for (k, row) in subject.rows.iter().enumerate() {
        cases[row.case()].push(k);
    }
    cases.retain(|rows| !rows.is_empty());
    Influence::new(fitted).left_out(&cases)
}

/// Rivals of every chosen hypothesis after their own refit; a rival that does better takes the place.
fn finish(
    subject: &Subject<'_>,
    mut current: Fitted,
    (mut best, places): (f64, usize),
    data: Data,
    accept: &dyn Fn(&Hypothesis) -> bool,
) -> Selected {
    let (mut gains, mut rivals) = (Vec::new(), Vec::new());
    let mut at = 0;
    let mut swaps = 0;
    while at < current.chosen.len() {
        let Some(base) = without(subject, &current, at, data, Effort::FULL) else {
            gains.push(0.0);
            rivals.push(Vec::new());
            at += 1;
            continue;
        };
        let value = criterion(&base, places);
        let own = &current.chosen[at];
        let unpredictive = !own.cause.of_the_measurement()
            && value < best + SURE
            && predicted(subject, &base) <= predicted(subject, &current);
        if value <= best || unpredictive {
            // What has been added since, or put in another's place, makes this one needless.
            (current, best) = (base, value);
            at = 0;
            gains.clear();
            rivals.clear();
            continue;
        }
        let own = current.chosen[at].clone();
        let gain = base.chi_square() - current.chi_square();
        let promising = survivors(screen(subject, &base), 0.3 * gain - 40.0, &|h| {
            !subject.budget.is_spent()
                && accept(h)
                && !h.same(&own)
                && !current
                    .chosen
                    .iter()
                    .any(|c| c.same_place(h) && !c.same(&own))
        });
        let mut found_rivals = Vec::new();
        let mut better: Option<(Fitted, f64)> = None;
        let reached = current.minimum.objective;
        let found = refits(subject, &base, &promising, data, reached);
        let instead: Vec<Option<Fitted>> = promising
            .par_iter()
            .map(|score| in_place_of(subject, (&current, at), score, data))
            .collect();
        let found = found.into_iter().zip(instead).map(|(a, b)| match (a, b) {
            (Some(a), Some(b)) if b.minimum.objective < a.minimum.objective => Some(b),
            (a, b) => a.or(b),
        });
        for (score, found) in promising.iter().zip(found) {
            let Some(found) = found else {
                continue;
            };
            let mut found = found;
            let mut value = criterion(&found, places);
            if value < best + CLOSE {
                found = polished(subject, found, data);
                value = criterion(&found, places);
            }
            let may_swap = swaps < SWAPS && !subject.budget.is_spent();
            if may_swap && value < better.as_ref().map_or(best - BETTER, |(_, v)| *v) {
                better = Some((found, value));
            } else if value - best <= RIVAL && !score.hypothesis.same_place(&own) {
                found_rivals.push(Rival {
                    cause: score.hypothesis.cause,
                    address: score.hypothesis.address.clone(),
                    behind: (value - best).max(0.0),
                    instead: Some((Arc::new(found), score.hypothesis.clone())),
                });
            }
        }
        if let Some((found, value)) = better {
            // The order of the findings changes: begin again.
            (current, best) = (found, value);
            swaps += 1;
            at = 0;
            gains.clear();
            rivals.clear();
            continue;
        }
        found_rivals.sort_by(|a, b| a.behind.total_cmp(&b.behind));
        for rival in found_rivals.iter_mut().skip(1) {
            rival.instead = None;
        }
        gains.push(gain);
        rivals.push(found_rivals);
        at += 1;
    }
    Selected {
        fitted: current,
        places,
        gains,
        rivals,
        gained: Vec::new(),
    }
}
