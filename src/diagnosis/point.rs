//! Fits at which all effects are linearised.

use std::collections::BTreeMap;

use super::candidate_effect::CandidateEffect;
use super::cause::Cause;
use super::causes::{dry_friction, free_play};
use super::closure::{EffectSet, Pool};
use super::reduction::{EffectModel, Marginal};

/// Set of effects, given by the indices of the effects in the list of known effects, in ascending order.
pub(super) type Ids = Vec<usize>;

/// Names of the forms of effects, by their indices in the list of known effects.
pub(super) type Forms = BTreeMap<usize, &'static str>;

/// Linearisation point: a fit at which all effects are linearised.
pub(super) struct Point {
    pub model: EffectModel,
    pub marginals: Vec<Marginal>,
    /// Sets of effects within Occam's window, one pool for each marginal.
    pub pools: Vec<Pool>,
    /// For each effect of `model`, the indices of its terms in the list of known effects. A combined effect has two terms.
    pub ids: Vec<Ids>,
}

impl Point {
    /// Returns the terms of a set, in ascending order.
    pub(super) fn ids_of(&self, set: &EffectSet) -> Ids {
        let mut ids: Ids = set.iter().flat_map(|k| self.ids[*k].clone()).collect();
        ids.sort_unstable();
        ids
    }

    /// Returns the forms of the effects of a set.
    pub(super) fn forms_of(&self, set: &EffectSet) -> Forms {
        let effects = &self.model.effects;
        let of = set.iter().flat_map(|k| {
            let ids = self.ids[*k].iter();
            ids.map(|id| (*id, effects[*k].form))
        });
        of.collect()
    }

    /// Returns the starts of an effect in a new fit, as pairs of a form of the effect and first guesses of its parameters. In general, there is one
    /// start per form. An effect that is in the fit has only one start, and so has an alternative function of a law that is in the fit.
    pub(super) fn starts(
        &self,
        k: usize,
        guesses: impl Fn(usize) -> Vec<f64>,
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
        let own = &self.model.effects[..self.model.own];
        if own.iter().any(|own| own.is_alternative(effect)) {
            return vec![(effect.clone(), guesses(k))];
        }
        if effect.cause == Cause::FreePlay {
            return free_play::starts(effect, &guesses(k));
        }
        // The starts are all forms of a law with memory, or all functions of any other law.
        let new = self.model.effects.iter().enumerate().skip(self.model.own);
        new.filter(|(_, form)| form.is_same_effect(effect))
            .map(|(j, form)| (form.clone(), guesses(j)))
            .collect()
    }

    /// Returns true if a set contains all effects of the fit.
    pub(super) fn holds_fit(&self, set: &EffectSet) -> bool {
        (0..self.model.own).all(|k| set.contains(&k))
    }

    /// Returns the effects of this point whose terms together are `ids`. Among alternative functions of a law, the function in `forms` is
    /// preferred. Returns `None` if a term is not a candidate at this point.
    pub(super) fn set_of(&self, ids: &Ids, forms: &Forms) -> Option<EffectSet> {
        let mut open = ids.clone();
        let mut set = EffectSet::new();
        let is_other = |k: usize, id: &usize| {
            let form = forms.get(id);
            form.is_some_and(|form| *form != self.model.effects[k].form)
        };
        // Combined effects come first, because their terms may also be separate candidates.
        for (count, any_form) in [(2, false), (2, true), (1, false), (1, true)] {
            for (k, terms) in self.ids.iter().enumerate() {
                if terms.len() == count
                    && (any_form || !terms.iter().any(|id| is_other(k, id)))
                    && terms.iter().all(|id| open.contains(id))
                {
                    open.retain(|id| !terms.contains(id));
                    set.push(k);
                }
            }
        }
        set.sort_unstable();
        open.is_empty().then_some(set)
    }
}

/// Law that its linear model approximates poorly.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum RoughLaw {
    /// Friction or creep. Each of them can look like the other.
    WithMemory,
    /// Law of any other cause.
    Of(Cause),
}

/// Returns the effects of a set that are not in the fit of the point and that a linear model approximates poorly, each with its law.
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
