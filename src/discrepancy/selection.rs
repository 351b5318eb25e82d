//! Which hypotheses go into the model: forward and backward, every step refitted jointly.

use super::cause::Cause;
use super::extended::{Fitted, fit};
use super::hypothesis::Hypothesis;
use super::screening::{Score, penalty, screen};
use super::subject::{Data, Subject};

/// Rivals whose criterion is within so much of the best one's cannot be told apart.
pub const RIVAL: f64 = 6.0;
/// A free-form cause has to do better by so much than any other.
const FREE_FORM: f64 = 6.0;
/// Places that are refitted in each step.
const SURVIVORS: usize = 8;
/// Causes at most.
const MOST: usize = 4;

/// A rival of a finding.
#[derive(Clone, Debug)]
pub struct Rival {
    /// What.
    pub cause: Cause,
    /// Where.
    pub address: String,
    /// By how much its criterion is behind, after its own refit.
    pub behind: f64,
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
}

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
fn survivors(scores: Vec<Score>, least: f64, accept: &dyn Fn(&Hypothesis) -> bool) -> Vec<Score> {
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
fn with(subject: &Subject<'_>, fitted: &Fitted, score: &Score, data: Data) -> Option<Fitted> {
    let mut all = chosen(fitted);
    all.push((score.hypothesis.clone(), score.estimate.clone()));
    let found = fit(subject, &all, Some(fitted), data)?;
    let last = found.chosen.len() - 1;
    (!found.has_wrong_sign(last)).then_some(found)
}

/// Fits `fitted` without one of its hypotheses.
fn without(subject: &Subject<'_>, fitted: &Fitted, at: usize, data: Data) -> Option<Fitted> {
    let mut all = chosen(fitted);
    all.remove(at);
    fit(subject, &all, Some(fitted), data)
}

/// Adds and drops hypotheses until nothing gains, starting from a fit. `accept` limits which may be added; only with `compare` is
/// each one held against its rivals, which takes most of the time.
pub fn select(
    subject: &Subject<'_>,
    start: Fitted,
    data: Data,
    accept: &dyn Fn(&Hypothesis) -> bool,
    compare: bool,
) -> Selected {
    let first = screen(subject, &start);
    let places = first.len() + start.chosen.len();
    let mut current = start;
    let mut best = criterion(&current, places);
    let mut scores = first;
    while current.chosen.len() < MOST {
        let tried = survivors(scores, 0.0, accept);
        let mut winner: Option<(Fitted, f64)> = None;
        for score in &tried {
            let Some(found) = with(subject, &current, score, data) else {
                continue;
            };
            let value = criterion(&found, places);
            if value < winner.as_ref().map_or(best, |(_, best)| *best) {
                winner = Some((found, value));
            }
        }
        let Some((found, value)) = winner else { break };
        (current, best) = (found, value);
        // A mimic goes again when the true cause is in.
        let mut at = 0;
        while current.chosen.len() > 1 && at + 1 < current.chosen.len() {
            if let Some(found) = without(subject, &current, at, data) {
                let value = criterion(&found, places);
                if value < best {
                    (current, best) = (found, value);
                    continue;
                }
            }
            at += 1;
        }
        scores = screen(subject, &current);
    }
    if !compare {
        let count = current.chosen.len();
        return Selected {
            fitted: current,
            places,
            gains: vec![0.0; count],
            rivals: vec![Vec::new(); count],
        };
    }
    finish(subject, current, (best, places), data, accept)
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
        let Some(base) = without(subject, &current, at, data) else {
            gains.push(0.0);
            rivals.push(Vec::new());
            at += 1;
            continue;
        };
        let value = criterion(&base, places);
        if value <= best {
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
            accept(h)
                && !h.same(&own)
                && !current
                    .chosen
                    .iter()
                    .any(|c| c.same_place(h) && !c.same(&own))
        });
        let mut found_rivals = Vec::new();
        let mut better: Option<(Fitted, f64)> = None;
        for score in &promising {
            let Some(found) = with(subject, &base, score, data) else {
                continue;
            };
            let value = criterion(&found, places);
            if value < better.as_ref().map_or(best, |(_, v)| *v) {
                better = Some((found, value));
            } else if value - best <= RIVAL && !score.hypothesis.same_place(&own) {
                found_rivals.push(Rival {
                    cause: score.hypothesis.cause,
                    address: score.hypothesis.address.clone(),
                    behind: value - best,
                });
            }
        }
        if let Some((found, value)) = better.filter(|_| swaps < 6) {
            // The order of the findings changes: begin again.
            (current, best) = (found, value);
            swaps += 1;
            at = 0;
            gains.clear();
            rivals.clear();
            continue;
        }
        found_rivals.sort_by(|a, b| a.behind.total_cmp(&b.behind));
        gains.push(gain);
        rivals.push(found_rivals);
        at += 1;
    }
    Selected {
        fitted: current,
        places,
        gains,
        rivals,
    }
}
