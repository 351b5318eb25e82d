//! Sets of effects that a selection compared, and how probable each is.

use std::sync::Arc;

use super::candidate_effect::{CandidateEffect, Term};
use super::fit::FittedModel;
use crate::settings::NAMED_PROBABILITY;

/// Set of effects that a selection compared.
#[derive(Clone, Debug)]
pub struct ModelSet {
    /// Effects of the set.
    pub causes: Vec<CandidateEffect>,
    /// Log posterior probability of the set, up to a constant: log evidence plus log prior odds.
    pub ln_posterior: f64,
    /// Fit of the set. `None` if its evidence is an estimate by the linear model of another fit.
    pub fitted: Option<Arc<FittedModel>>,
}

/// Result of a selection of effects.
#[derive(Debug)]
pub struct Selected {
    /// Fit without effects.
    pub none: Arc<FittedModel>,
    /// Sets within Occam's window, with probabilities that add up to one, the most probable first.
    pub models: Vec<(ModelSet, f64)>,
    /// Fits of probable sets and of their subsets. A subset may be improbable.
    pub fits: Vec<Arc<FittedModel>>,
    /// Number of candidate effects.
    pub places: usize,
    /// True if the selection ended early: its budget was spent, or the user stopped it.
    pub cut_short: bool,
    /// Fit that is reported: the most probable fitted set, without effects that are less probable than not.
    pub leading: Arc<FittedModel>,
}

impl Selected {
    /// Returns the probability that the effects of the true set satisfy `accept`.
    pub(super) fn probability(&self, accept: impl Fn(&[CandidateEffect]) -> bool) -> f64 {
        probability(&self.models, accept)
    }

    /// Returns the probability that no cause of the catalogue acts.
    pub(super) fn none_of_these(&self) -> f64 {
        none_of_these(&self.models)
    }

    /// Returns the probability of a cause at its site.
    pub(super) fn of_site(&self, h: &CandidateEffect) -> f64 {
        self.probability(|causes| causes.iter().any(|other| other.same_site(h)))
    }

    /// Returns the sets that hold another cause in place of effect `at` of the leading set. Each set is paired with this other cause. The
    /// remaining causes of both sets are at the same sites.
    pub(super) fn rivals(&self, at: usize) -> impl Iterator<Item = (&ModelSet, &CandidateEffect)> {
        let leading = &self.leading.effects;
        let each = self.models.iter();
        each.filter_map(move |(model, _)| Some((model, instead(&model.causes, leading, at)?)))
    }
}

/// Returns the cause that a set contains in place of effect `at` of the leading set. All other causes of the two sets must be at the same sites.
pub(super) fn instead<'m>(
    causes: &'m [CandidateEffect],
    leading: &[CandidateEffect],
    at: usize,
) -> Option<&'m CandidateEffect> {
    let own = &leading[at];
    let others = CandidateEffect::causes(leading).filter(|h| !h.same_site(own));
    let mut rest: Vec<&CandidateEffect> = CandidateEffect::causes(causes).collect();
    if rest.len() != CandidateEffect::causes(leading).count() {
        return None;
    }
    for other in others {
        let place = rest.iter().position(|h| h.same_site(other))?;
        rest.remove(place);
    }
    rest.pop().filter(|h| !h.same_site(own))
}

/// Returns the probability of all sets whose effects satisfy `accept`.
pub(super) fn probability(
    models: &[(ModelSet, f64)],
    accept: impl Fn(&[CandidateEffect]) -> bool,
) -> f64 {
    let accepted = models.iter().filter(|(model, _)| accept(&model.causes));
    // The sum starts at zero, because the sum of no numbers is negative zero.
    let sum = accepted.fold(0.0, |sum, (_, probability)| sum + probability);
    sum.min(1.0)
}

/// Returns the probability that no cause of the catalogue acts.
pub(super) fn none_of_these(models: &[(ModelSet, f64)]) -> f64 {
    probability(models, |causes| {
        !causes.iter().any(CandidateEffect::is_in_catalogue)
    })
}

/// Returns the sets with their probabilities, the most probable first.
pub(super) fn weighted(sets: Vec<ModelSet>) -> Vec<(ModelSet, f64)> {
    let each = sets.iter().map(|set| set.ln_posterior);
    let best = each.fold(f64::NEG_INFINITY, f64::max);
    let weight = |set: &ModelSet| libm::exp(set.ln_posterior - best);
    let sum: f64 = sets.iter().map(weight).sum();
    let mut out: Vec<(ModelSet, f64)> = sets
        .into_iter()
        .map(|set| {
            let probability = weight(&set) / sum;
            (set, probability)
        })
        .collect();
    out.sort_by(|a, b| b.1.total_cmp(&a.1));
    out
}

/// Returns the fit that is reported: the most probable fitted set, or the most probable one with a cause if some cause acts with a probability
/// above one half. An effect is left out if the group of all effects indistinguishable from it is less probable than not. This requires that the
/// set without such effects is fitted, too.
pub(super) fn leading(models: &[(ModelSet, f64)], none: &Arc<FittedModel>) -> Arc<FittedModel> {
    let acts = none_of_these(models) < NAMED_PROBABILITY;
    let fits = || models.iter().filter_map(|(model, _)| model.fitted.as_ref());
    let has_cause = |fitted: &&Arc<FittedModel>| {
        !acts || fitted.effects.iter().any(CandidateEffect::is_in_catalogue)
    };
    let Some(best) = fits().find(has_cause).or_else(|| fits().next()) else {
        return Arc::clone(none);
    };
    let is_named = |at: usize| {
        let own = &best.effects[at];
        let mut members = vec![own];
        for (model, _) in models {
            members.extend(instead(&model.causes, &best.effects, at));
        }
        let group = probability(models, |causes| {
            causes
                .iter()
                .any(|h| members.iter().any(|m| m.same_site(h)))
        });
        own.term != Term::Main || group > NAMED_PROBABILITY
    };
    let unnamed: Vec<&CandidateEffect> = (0..best.effects.len())
        .filter(|at| !is_named(*at))
        .map(|at| &best.effects[at])
        .collect();
    if unnamed.is_empty() {
        return Arc::clone(best);
    }
    let is_out = |h: &CandidateEffect| unnamed.iter().any(|other| other.same_site(h));
    let named: Vec<_> = best.effects.iter().filter(|h| !is_out(h)).collect();
    let is_rest = |fitted: &&Arc<FittedModel>| {
        fitted.effects.len() == named.len()
            && named
                .iter()
                .all(|h| fitted.effects.iter().any(|other| other.same_law(h)))
    };
    Arc::clone(fits().find(is_rest).unwrap_or(best))
}
