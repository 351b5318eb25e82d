//! Fits at which all effects are linearised.

use super::candidate_effect::CandidateEffect;
use super::cause::Cause;
use super::causes::dry_friction;
use super::challengers::Challenger;
use super::closure::{EffectSet, Pool};
use super::reduction::{EffectModel, Marginal};

/// Set of effects, given by the indices of the effects in the list of known effects, in ascending order.
pub(super) type Ids = Vec<usize>;

/// Linearisation point: a fit at which all effects are linearised.
pub(super) struct Point {
    pub model: EffectModel,
    pub marginals: Vec<Marginal>,
    /// Sets of effects within Occam's window, one pool for each marginal.
    pub pools: Vec<Pool>,
    /// Sets that the fit must be compared with if it leads.
    pub challengers: Vec<Challenger>,
    /// Indices in the list of known effects of the terms of each effect of `model`. A combined effect has two.
    pub ids: Vec<Ids>,
}

impl Point {
    /// Returns the terms of a set, in ascending order.
    pub(super) fn ids_of(&self, set: &EffectSet) -> Ids {
        let mut ids: Ids = set.iter().flat_map(|k| self.ids[*k].clone()).collect();
        ids.sort_unstable();
        ids
    }

    /// Returns the starts of an effect in a new fit: its forms, if it is a law with memory, each with first guesses of its parameters.
    pub(super) fn starts(
        &self,
        k: usize,
        guesses: impl Fn() -> Vec<f64>,
    ) -> Vec<(CandidateEffect, Vec<f64>)> {
        let effect = &self.model.effects[k];
        if let Some(scan) = &self.model.scans[k] {
            let starts = scan.starts.iter();
            return starts
                .map(|start| dry_friction::started(effect, start))
                .collect();
        }
        if k < self.model.own {
            return vec![(effect.clone(), vec![0.0; effect.numbers.len()])];
        }
        if effect.memory.is_none() {
            return vec![(effect.clone(), guesses())];
        }
        let forms = self.model.effects.iter().skip(self.model.own);
        forms
            .filter(|form| form.same_law(effect))
            .map(|form| (form.clone(), guesses()))
            .collect()
    }

    /// Returns the effects of the fit that a set does not contain.
    pub(super) fn left_out(&self, set: &EffectSet) -> EffectSet {
        let own = 0..self.model.own;
        own.filter(|k| !set.contains(k)).collect()
    }

    /// Returns the effects of this point that have these terms together. Returns `None` if a term is not a candidate at this point.
    pub(super) fn set_of(&self, ids: &Ids) -> Option<EffectSet> {
        let mut open = ids.clone();
        let mut set = EffectSet::new();
        // Combined effects come first: their terms may be candidates of their own, too.
        for count in [2, 1] {
            for (k, terms) in self.ids.iter().enumerate() {
                if terms.len() == count && terms.iter().all(|id| open.contains(id)) {
                    open.retain(|id| !terms.contains(id));
                    set.push(k);
                }
            }
        }
        set.sort_unstable();
        open.is_empty().then_some(set)
    }
}

/// Law whose linear model is rough.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum RoughLaw {
    /// Friction or creep. Each of them can look like the other.
    WithMemory,
    /// Law of any other cause.
    Of(Cause),
}

/// Returns the effects of a set that are not in the fit of the point and whose laws are rough, with their laws.
pub(super) fn new_rough_laws(
    model: &EffectModel,
    set: &[usize],
) -> impl Iterator<Item = (usize, RoughLaw)> {
    let new = set.iter().copied().filter(|k| *k >= model.own);
    new.filter_map(|k| {
        let effect = &model.effects[k];
        if effect.memory.is_some() {
            return Some((k, RoughLaw::WithMemory));
        }
        let is_rough = effect.is_poorly_linearised();
        is_rough.then_some((k, RoughLaw::Of(effect.cause)))
    })
}
