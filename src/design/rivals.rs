//! Two rival explanations of the same readings, and the ability of a further measurement to distinguish them.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix};
use serde::Serialize;

use super::candidate::ProposedMeasurements;
use super::information::Information;
use super::prospect::{MeasurementPredictor, Readings};
use crate::settings::RIVAL_MIN_PROBABILITY;
use admire_diagnosis::{CandidateEffect, DiagnosisProblem, FittedModel, ModelSet, Selected};

/// Leading model and its most probable rival.
#[derive(Clone, Debug)]
pub(super) struct CompetingModels {
    /// Both fits, the leading model first.
    pub fits: [Arc<FittedModel>; 2],
    /// Names of the causes that each model contains and the other model does not contain.
    pub names: [String; 2],
    /// Posterior probability of each of the two models, among all models of the search.
    pub probability: [f64; 2],
}

/// Expected ability of a measurement to distinguish two rival models.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Separation {
    /// Expected chi-square between the predictions of the two rivals.
    pub chi_square: f64,
    /// True if the chi-square is a lower bound, because the loads deflect the mechanism farther than the study does.
    pub at_least: bool,
    /// Expected increase of the true model's probability.
    pub probability_shift: f64,
    /// Expected information about which of the two models is true, in nats.
    pub nats: f64,
}

impl CompetingModels {
    /// Returns the leading model and its most probable rival from a selection, or `None` if no rival is probable enough.
    pub(super) fn of(selected: &Selected) -> Option<Self> {
        let leading = &selected.leading;
        let fitted = |(model, p): &(ModelSet, f64)| Some((Arc::clone(model.fitted.as_ref()?), *p));
        let mut fits: Vec<(Arc<FittedModel>, f64)> =
            selected.models.iter().filter_map(fitted).collect();
        let at = fits.iter().position(|(fit, _)| Arc::ptr_eq(fit, leading))?;
        let (own, p) = fits.remove(at);
        let differs =
            |fit: &FittedModel| !without(fit, &own).is_empty() || !without(&own, fit).is_empty();
        let (other, q) = fits.into_iter().find(|(fit, _)| differs(fit))?;
        let names = [without(&own, &other), without(&other, &own)].map(|causes| {
            if causes.is_empty() {
                "no such cause".to_string()
            } else {
                let names: Vec<String> = causes.iter().map(ToString::to_string).collect();
                names.join(" and ")
            }
        });
        (q / (p + q) > RIVAL_MIN_PROBABILITY).then_some(Self {
            fits: [own, other],
            names,
            probability: [p, q],
        })
    }

    /// Returns true if the response of either model depends on the order of the load cases.
    pub(super) fn remember(&self) -> bool {
        let mut causes = self.fits.iter().flat_map(|fit| &fit.effects);
        causes.any(|h| h.memory.is_some())
    }

    /// Returns the probability of the leading model, given that one of the two models is true.
    pub(super) fn probability_of_first(&self) -> f64 {
        self.probability[0] / (self.probability[0] + self.probability[1])
    }
}

/// Chi-square between the predictions of two rival models in a candidate measurement.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Discrimination {
    /// Chi-square. If the loads deflect the mechanism farther than in the study, the chi-square is computed for smaller loads, within the range of
    /// the study.
    pub chi_square: f64,
    /// True if the chi-square is a lower bound, because the loads deflect the mechanism farther than in the study.
    pub is_at_least: bool,
}

impl std::fmt::Display for Discrimination {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let word = if self.is_at_least {
            "above"
        } else {
            "of about"
        };
        write!(f, "a chi-square {word} {:.1}", self.chi_square)
    }
}

/// Two models, prepared for their comparison in each candidate measurement.
struct Pair<'a, 'b> {
    predictors: [MeasurementPredictor<'a, 'b>; 2],
    information: Information,
}

impl<'a, 'b> Pair<'a, 'b> {
    fn new(
        subject: &'a DiagnosisProblem<'b>,
        fits: [&'a FittedModel; 2],
        candidates: &'a ProposedMeasurements,
    ) -> Option<Self> {
        let [first, second] = fits.map(|fit| MeasurementPredictor::new(subject, fit, candidates));
        Some(Self {
            predictors: [first?, second?],
            information: Information::of(fits[0]),
        })
    }

    fn chi_square(&self, at: usize) -> Option<f64> {
        let [first, second] = self.predictors.each_ref().map(|p| p.readings(at));
        discrimination_chi_square(&self.information, &first?, &second?)
    }

    /// Returns the larger of the deflection ratios of the two models, but at least one. A model without an equilibrium does not count.
    fn reach(&self, at: usize) -> f64 {
        let each = self.predictors.each_ref().map(|p| p.reach(at));
        each.into_iter().flatten().fold(1.0, f64::max)
    }
}

/// Compares the predictions of two models in each candidate measurement. An entry is `None` if the candidate cannot be measured. No reading
/// constrains the models beyond the deflections of the study, so their difference counts only up to these deflections.
pub(super) fn discriminations(
    subject: &DiagnosisProblem<'_>,
    fits: [&FittedModel; 2],
    candidates: &ProposedMeasurements,
) -> Option<Vec<Option<Discrimination>>> {
    let whole = Pair::new(subject, fits, candidates)?;
    let all = 0..candidates.list.len();
    let reach: Vec<f64> = all.clone().map(|at| whole.reach(at)).collect();
    let (reduced, places) = candidates.reduced(subject.problem.programme, &reach);
    let nearer = if reduced.list.is_empty() {
        None
    } else {
        Pair::new(subject, fits, &reduced)
    };
    let of = |at: usize| {
        let (chi_square, is_at_least) = match places[at] {
            None => (whole.chi_square(at)?, false),
            Some(place) => (nearer.as_ref()?.chi_square(place)?, true),
        };
        Some(Discrimination {
            chi_square: chi_square.max(0.0),
            is_at_least,
        })
    };
    Some(all.map(of).collect())
}

/// Returns the causes of a model at sites where the other model has no cause.
fn without<'a>(fit: &'a FittedModel, other: &FittedModel) -> Vec<&'a CandidateEffect> {
    let there = |h: &&CandidateEffect| !other.effects.iter().any(|o| o.same_site(h));
    fit.effects.iter().filter(there).collect()
}

/// Returns the chi-square `d' (I + J C J')^-1 d` that distinguishes two models, with the difference `d` of their predicted readings. The
/// uncertainty of the first model's prediction is part of the covariance.
fn discrimination_chi_square(
    information: &Information,
    first: &Readings,
    second: &Readings,
) -> Option<f64> {
    let (difference, rows) = first.against(second)?;
    let known = information.with_nuisance(&first.further);
    let S = known.covariance(rows)? + DMatrix::identity(rows.nrows(), rows.nrows());
    Some(difference.dot(&Cholesky::new(S)?.solve(&difference)))
}

impl Separation {
    /// Returns the expected benefit of a measurement that distinguishes two models by this chi-square. `odds` is the probability of the first model
    /// before the measurement. The log Bayes factor in favour of the true model is Gaussian. Its mean is half the chi-square, and its variance is the
    /// chi-square.
    pub(super) fn of(found: Discrimination, odds: f64) -> Self {
        let chi_square = found.chi_square;
        let (mut right, mut entropy, mut sum) = (0.0, 0.0, 0.0);
        let prior = libm::log(odds / (1.0 - odds));
        for step in -80..=80 {
            let z = f64::from(step) * 0.1;
            let weight = libm::exp(-0.5 * z * z);
            sum += weight;
            for (share, sign) in [(odds, 1.0), (1.0 - odds, -1.0)] {
                let factor = sign * 0.5 * chi_square + chi_square.sqrt() * z;
                let first = 1.0 / (1.0 + libm::exp(-(prior + factor)));
                let own = if sign > 0.0 { first } else { 1.0 - first };
                right += weight * share * own;
                entropy += weight * share * of_two(first);
            }
        }
        let before = odds * odds + (1.0 - odds) * (1.0 - odds);
        Self {
            chi_square,
            at_least: found.is_at_least,
            probability_shift: (right / sum - before).max(0.0),
            nats: (of_two(odds) - entropy / sum).max(0.0),
        }
    }
}

/// Returns the entropy of a choice between two alternatives with probabilities `p` and `1 - p`, in nats.
fn of_two(p: f64) -> f64 {
    let term = |p: f64| if p > 0.0 { -p * libm::log(p) } else { 0.0 };
    term(p) + term(1.0 - p)
}

#[cfg(test)]
mod tests {
    use super::{Discrimination, Separation};

    fn separation(chi_square: f64, odds: f64) -> Separation {
        let found = Discrimination {
            chi_square,
            is_at_least: false,
        };
        Separation::of(found, odds)
    }

    #[test]
    fn what_tells_nothing_shifts_nothing_and_what_tells_all_decides() {
        let none = separation(0.0, 0.7);
        assert!(none.probability_shift < 1e-12 && none.nats < 1e-12);
        let all = separation(400.0, 0.7);
        // The expected probability of the true model rises from 0.7^2 + 0.3^2 to one, and all entropy is removed.
        assert!((all.probability_shift - 0.42).abs() < 1e-6);
        assert!((all.nats - (-0.7 * 0.7_f64.ln() - 0.3 * 0.3_f64.ln())).abs() < 1e-6);
    }

    /// For a small chi-square `D^2`, the expected probability of the true model rises by `2 p^2 q^2 D^2`, and the expected information is `p
    /// q D^2 / 2`.
    #[test]
    fn small_separations_are_those_of_the_series() {
        let (p, q, d2) = (0.6, 0.4, 1e-3);
        let found = separation(d2, p);
        assert!(
            (found.nats / (0.5 * p * q * d2) - 1.0).abs() < 0.01,
            "{found:?}"
        );
        let shift = 2.0 * p * p * q * q * d2;
        assert!(
            (found.probability_shift / shift - 1.0).abs() < 0.01,
            "{found:?}"
        );
    }
}
