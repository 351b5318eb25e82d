//! Sets of effects that are fitted for comparison with the most probable fit. The linear model at that fit may estimate their posterior
//! probabilities wrongly.

use std::collections::BTreeMap;

use super::candidate_effect::CandidateEffect;
use super::cause::Cause;
use super::closure::{EffectSet, Sets};
use super::reduction::{EffectModel, Marginal};
use super::settings::RESOLVED_PROBABILITY;

/// Reason why a set is compared with the leading fit.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Reason {
    /// A law of the catalogue takes the place of a force of unknown law at the same site.
    KnownLaw,
    /// The law of one cause has another function.
    OtherFunction,
    /// One effect is left out. Without it, other variance components may be more probable.
    LeftOut,
    /// A law with memory has a further term, whose evidence no linear model can estimate.
    FurtherTerm,
    /// One cause is exchanged for a cause whose size is unusual, so that its linear model is wrong.
    UnusualSize,
    /// One cause is exchanged for a cause that explains the readings about as well.
    Rival,
}

/// Set of effects to compare with the leading fit.
#[derive(Clone, Debug)]
pub(super) struct Challenger {
    pub set: EffectSet,
    pub reason: Reason,
    /// Log posterior of the set in the linear model at the fit.
    pub expected: f64,
}

/// Returns the sets of effects that must be compared with the fit at which `model` is linearised. As a side effect, computes and stores the
/// columns of the information matrix that these sets need.
pub(super) fn challengers(model: &EffectModel, marginal: &Marginal) -> Vec<Challenger> {
    let sets = Sets::new(model, marginal);
    let own: EffectSet = (0..model.own).collect();
    let best = model.fitted.ln_posterior();
    let unresolved = libm::log(RESOLVED_PROBABILITY);
    let mut out = Vec::new();
    let mut put = |set: EffectSet, reason: Reason| {
        // In the linear model, an effect that stays may get the wrong sign when another is left out. The fit may not.
        let expected = match sets.score(&set) {
            Some(score) => marginal.ln_z + score,
            None if reason == Reason::LeftOut => f64::NEG_INFINITY,
            None => return,
        };
        out.push(Challenger {
            set,
            reason,
            expected,
        });
    };
    for (k, effect) in model.effects[..model.own].iter().enumerate() {
        let others: EffectSet = own.iter().copied().filter(|other| *other != k).collect();
        let other_function =
            |j: &usize| *j >= model.own && model.effects[*j].is_alternative(effect);
        for j in (0..model.effects.len()).filter(other_function) {
            put(with(&others, j), Reason::OtherFunction);
        }
        // A law is left out with all its terms.
        let is_term = |other: &usize| model.effects[*other].same_site(effect);
        let mut rest = others;
        if !sets.may_leave(&own, k) {
            rest.retain(|other| !is_term(other));
        }
        if !rest.is_empty() {
            put(rest.clone(), Reason::LeftOut);
        }
        // The best set of each cause, with its score.
        let mut best_of: BTreeMap<(Reason, Cause), (f64, EffectSet)> = BTreeMap::new();
        for addition in sets.additions(&rest) {
            let new = &model.effects[addition.effect];
            if addition.effect < model.own || !new.is_in_catalogue() {
                continue;
            }
            let set = with(&rest, addition.effect);
            let behind = best - (marginal.ln_z + addition.score);
            let reason = if !effect.is_in_catalogue() && new.address == effect.address {
                Reason::KnownLaw
            } else if behind < -unresolved {
                put(set, Reason::Rival);
                continue;
            } else if behind - 0.5 * addition.mean.norm_squared() < -unresolved {
                Reason::UnusualSize
            } else {
                continue;
            };
            let key = (reason, new.cause);
            if best_of
                .get(&key)
                .is_none_or(|(known, _)| addition.score > *known)
            {
                best_of.insert(key, (addition.score, set));
            }
        }
        for ((reason, _), (_, set)) in best_of {
            put(set, reason);
        }
    }
    for (k, effect) in model.effects.iter().enumerate().skip(model.own) {
        let of = |own: &CandidateEffect| own.memory.is_some() && own.same_site(effect);
        if model.effects[..model.own].iter().any(of) {
            put(with(&own, k), Reason::FurtherTerm);
        }
    }
    out.sort_by_key(|challenger| challenger.reason);
    out
}

/// Returns a set with one more effect, whose index is larger than all others.
fn with(set: &EffectSet, effect: usize) -> EffectSet {
    set.iter().copied().chain([effect]).collect()
}
