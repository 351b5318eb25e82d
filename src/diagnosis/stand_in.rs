//! Forces of unknown laws in the place of causes: against many causes together, and where a law of a cause leaves something at its own
//! element.

use std::sync::Arc;

use super::candidate_effect::{CandidateEffect, Term};
use super::fit::{EarlyStopping, FitOutcome, FittedModel, with_zero_guesses};
use super::remainder::{GpTerm, gp_terms, left_by_laws, sites_of};
use super::tried::{BETTER, Tried};
use super::visited::same_set;

/// So many causes of a model, or faults of the readings of single cases, may together be one effect that no cause has.
const MANY: usize = 3;
/// Where such a force begins so many times as far off as the model without it, weights and priors counted, what the linear model says
/// of it holds no longer.
const WILD: f64 = 1000.0;

/// Such forces that were tried.
#[derive(Default)]
pub(super) struct StandIns {
    /// Sets of causes, and the best model of each with one force of a law that no cause has.
    beside: Vec<(Vec<CandidateEffect>, Option<Arc<FittedModel>>)>,
}

impl StandIns {
    /// Holds many causes against one force of a law that none of them has: against all of them, and against faults of single cases.
    /// `None` where they do better.
    pub(super) fn unnamed(
        &mut self,
        tried: &mut Tried<'_, '_>,
        current: &Arc<FittedModel>,
    ) -> Option<Arc<FittedModel>> {
        let subject = tried.subject;
        let named = || current.effects.iter().filter(|h| h.is_in_catalogue());
        let many = named().filter(|h| h.term == Term::Main).count();
        if many < MANY || subject.budget_exhausted() {
            return None;
        }
        let of_the_model = |h: &&CandidateEffect| h.only_case(&subject.rows).is_none();
        let rest: Vec<CandidateEffect> = named().filter(of_the_model).cloned().collect();
        let mut bases = vec![Vec::new()];
        if !rest.is_empty() && rest.len() + MANY <= named().count() {
            bases.push(rest);
        }
        let mut best: Option<Arc<FittedModel>> = None;
        for causes in bases {
            let Some(found) = self.beside(tried, current, causes) else {
                continue;
            };
            let leads = best.as_deref().unwrap_or(current).ln_posterior();
            if found.ln_posterior() > leads + BETTER {
                best = Some(found);
            }
        }
        best
    }

    /// The best model of one such force and some of the causes of a fit; `None` where no force stands out beside them.
    pub(super) fn beside(
        &mut self,
        tried: &mut Tried<'_, '_>,
        current: &Arc<FittedModel>,
        causes: Vec<CandidateEffect>,
    ) -> Option<Arc<FittedModel>> {
        let known = self.beside.iter().find(|(of, _)| same_set(of, &causes));
        if let Some((_, found)) = known {
            return found.clone();
        }
        let base = tried.of(current, causes.clone())?;
        let mut best: Option<Arc<FittedModel>> = None;
        for force in gp_terms(tried.subject, &base, &sites_of(tried.subject, &base)) {
            let lead = best.as_deref().unwrap_or(current).ln_posterior();
            let found = standing_in(tried, &base, &force, lead);
            let leads = |f: &Arc<FittedModel>| f.ln_posterior();
            if found.as_ref().map(leads) > best.as_ref().map(leads) {
                best = found;
            }
        }
        self.beside.push((causes, best.clone()));
        best
    }
}

/// The best model in which a law leaves something at its own element, beside all other causes or in place of some. `None` where
/// none is better.
pub(super) fn loosened(
    tried: &mut Tried<'_, '_>,
    current: &Arc<FittedModel>,
) -> Option<Arc<FittedModel>> {
    let rough = |h: &CandidateEffect| h.cause.has_rough_law();
    if tried.subject.budget_exhausted() || !current.effects.iter().any(rough) {
        return None;
    }
    let mut bases = vec![Arc::clone(current)];
    let alone: Vec<CandidateEffect> = current
        .effects
        .iter()
        .filter(|h| rough(h))
        .cloned()
        .collect();
    let others: Vec<usize> = (0..current.effects.len())
        .filter(|at| !rough(&current.effects[*at]))
        .collect();
    if others.len() > 1 {
        bases.extend(tried.of(current, alone));
    }
    for at in others {
        bases.extend(tried.without(current, at));
    }
    // A law met badly looks like a second one at another element: each place is tried without the laws of all others, too.
    let mut places: Vec<&CandidateEffect> = Vec::new();
    for h in current.effects.iter().filter(|h| rough(h)) {
        if !places.iter().any(|other| other.same_site(h)) {
            places.push(h);
        }
    }
    if places.len() > 1 {
        for place in places {
            let own = current.effects.iter();
            let own = own.filter(|h| !rough(h) || h.same_site(place));
            bases.extend(tried.of(current, own.cloned().collect()));
        }
    }
    let mut best: Option<Arc<FittedModel>> = None;
    for base in bases {
        for force in left_by_laws(tried.subject, &base, &sites_of(tried.subject, &base)) {
            let leads = best.as_deref().unwrap_or(current).ln_posterior();
            let found = standing_in(tried, &base, &force, leads);
            best = found
                .filter(|found| found.ln_posterior() > leads + BETTER)
                .or(best);
        }
    }
    best
}

/// The best model in which friction leaves something at its own element, where the linear model expects more of that than `first`, the
/// evidence that it expects of the next cause, and what it comes to is more, too.
pub(super) fn left_by_friction(
    tried: &mut Tried<'_, '_>,
    base: &FittedModel,
    first: f64,
) -> Option<Arc<FittedModel>> {
    if base.effects.iter().all(|h| h.memory.is_none()) {
        return None;
    }
    let mut best: Option<Arc<FittedModel>> = None;
    for force in left_by_laws(tried.subject, base, &sites_of(tried.subject, base)) {
        let leads = best.as_ref().map_or(first, |found| found.ln_posterior());
        if base.ln_posterior() + force.nats + force.hypothesis.ln_prior < leads {
            continue;
        }
        let found = standing_in(tried, base, &force, leads);
        best = found.filter(|found| found.ln_posterior() > leads).or(best);
    }
    best
}

/// Fits a model with such a force, then once more with what the force does linearised where that ended, as long as that may come near
/// to `lead` nats, prior included.
fn standing_in(
    tried: &mut Tried<'_, '_>,
    base: &FittedModel,
    force: &GpTerm,
    lead: f64,
) -> Option<Arc<FittedModel>> {
    let subject = tried.subject;
    let mut all = with_zero_guesses(base);
    all.push((force.hypothesis.clone(), force.guesses.clone()));
    let chosen: Vec<CandidateEffect> = all.iter().map(|(h, _)| h.clone()).collect();
    let target = EarlyStopping {
        lead: lead - CandidateEffect::ln_prior_of(&chosen),
        least: -0.5 * WILD * base.linear.objective(&base.sizes),
        ..EarlyStopping::NONE
    };
    let mut fitted = |all: &[(CandidateEffect, Vec<f64>)], from: &FittedModel, x: &[f64]| {
        let fit = tried.fitted(all, Some((from, x)), None, target)?;
        match fit {
            FitOutcome::New(fitted) => Some(fitted),
            FitOutcome::Duplicate => None,
        }
    };
    let mut begun = |x: &[f64]| fitted(&all, base, x).filter(|found| !target.is_astray(found));
    let first = begun(&force.x).or_else(|| begun(&base.x))?;
    let mut again = with_zero_guesses(&first);
    if let Some((last, _)) = again.last_mut() {
        *last = force.at(subject, &first);
    }
    let second = (!target.is_beaten(&first)).then(|| fitted(&again, &first, &first.x));
    let second = second.flatten();
    let better = second.filter(|second| second.ln_posterior() > first.ln_posterior());
    let found = better.unwrap_or(first);
    tried.note(&found);
    Some(found)
}
