//! Selection of effects. Linear models propose probable sets of effects, and full fits confirm them, the most probable set first. The selection
//! ends when every set that is probable enough is fitted, or predicts the same as a fitted set, or when the budget is spent.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::candidate_effect::{CandidateEffect, Term};
use super::cause::Cause;
use super::causes::dry_friction;
use super::closure::{EffectSet, Pool, Sets};
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::early_stopping::EarlyStopping;
use super::fit::{FittedModel, fit_with_early_stopping, with_zero_guesses};
use super::model_set::{ModelSet, Selected, instead, none_of_these, probability, weighted};
use super::reduction::{EffectModel, Marginal};
use super::remainder::{GpTerm, gp_terms, left_by_laws, sites_of};
use super::settings::{
    EQUIVALENT_DISTANCE, MAX_LN_STIFFNESS_START, MAX_SELECTION_FITS, MAX_SELECTION_POINTS,
    NAMED_PROBABILITY, OCCAM_WINDOW_NATS, RESOLVED_PROBABILITY,
};

/// Set of effects, given by the indices of the effects in `Selector::known`, in ascending order.
type Ids = Vec<usize>;

/// Linearisation point: a fit at which all effects are linearised.
struct Point {
    model: EffectModel,
    marginals: Vec<Marginal>,
    /// Sets of effects within Occam's window, one pool for each marginal.
    pools: Vec<Pool>,
    /// Index in `Selector::known` of each effect of `model`.
    ids: Vec<usize>,
}

/// Estimated log posterior of a set of effects that is not fitted.
struct SetEstimate {
    ln_posterior: f64,
    /// Squared distance between the predictions of this set and of the nearest fitted set, in units of noise.
    distance: f64,
    point: usize,
    marginal: usize,
    set: EffectSet,
}

/// Fitted set of effects.
struct Fit {
    ln_posterior: f64,
    /// The fit itself. `None` if it is outside of Occam's window, to save memory.
    model: Option<Arc<FittedModel>>,
}

impl Fit {
    fn new(fitted: &Arc<FittedModel>) -> Self {
        Self {
            ln_posterior: fitted.ln_posterior(),
            model: Some(Arc::clone(fitted)),
        }
    }
}

struct Selector<'a, 'b> {
    /// Fit without effects.
    none: Arc<FittedModel>,
    subject: &'a DiagnosisProblem<'b>,
    data: Data,
    known: Vec<CandidateEffect>,
    /// Forces of unknown law that were candidates at a linearisation point.
    forces: Vec<GpTerm>,
    fits: BTreeMap<Ids, Fit>,
    /// Sets that are not fitted again: their fit failed, or an effect had the wrong sign.
    discarded: BTreeSet<Ids>,
    points: Vec<Point>,
    count: usize,
}

/// Selects effects by comparing fits, starting from `none`, the fit without effects.
pub(super) fn select(
    subject: &DiagnosisProblem<'_>,
    none: &Arc<FittedModel>,
    data: Data,
) -> Selected {
    let mut selector = Selector {
        none: Arc::clone(none),
        subject,
        data,
        known: Vec::new(),
        forces: Vec::new(),
        fits: BTreeMap::new(),
        discarded: BTreeSet::new(),
        points: Vec::new(),
        count: 1,
    };
    selector.fits.insert(Vec::new(), Fit::new(none));
    selector.add_point(none);
    selector.run();
    let first = selector.selected();
    if selector.fit_rivals(&first) {
        selector.selected()
    } else {
        first
    }
}

impl Selector<'_, '_> {
    fn run(&mut self) {
        while self.count < MAX_SELECTION_FITS
            && !self.subject.budget_exhausted()
            && !self.subject.progress().is_stopped()
        {
            let least = self.best() + libm::log(RESOLVED_PROBABILITY);
            let open = self.estimates().into_iter().filter(|(_, estimate)| {
                estimate.ln_posterior > least && estimate.distance > EQUIVALENT_DISTANCE
            });
            let next = open.max_by(|a, b| a.1.ln_posterior.total_cmp(&b.1.ln_posterior));
            let Some((ids, estimate)) = next else { break };
            self.confirm(&ids, &estimate);
        }
    }

    /// Fits the most probable rival of each cause in the leading set, if no rival is fitted yet: what is equivalent was not fitted, but a report
    /// shows it, and a plan tells the two apart. Returns true if anything was fitted.
    fn fit_rivals(&mut self, selected: &Selected) -> bool {
        let count = self.count;
        for at in 0..selected.leading.effects.len() {
            let mut rivals = selected.rivals(at).peekable();
            let Some((first, _)) = rivals.peek() else {
                continue;
            };
            if first.fitted.is_some() || self.subject.budget_exhausted() {
                continue;
            }
            let is_same = |ids: &Ids| {
                ids.len() == first.causes.len()
                    && ids.iter().all(|id| {
                        let known = &self.known[*id];
                        first.causes.iter().any(|h| h.same_law(known))
                    })
            };
            let open = self.estimates().into_iter().find(|(ids, _)| is_same(ids));
            if let Some((ids, estimate)) = open {
                self.confirm(&ids, &estimate);
            }
        }
        self.count > count
    }

    fn best(&self) -> f64 {
        let all = self.fits.values().map(|fit| fit.ln_posterior);
        all.fold(f64::NEG_INFINITY, f64::max)
    }

    fn id(&mut self, effect: &CandidateEffect) -> usize {
        if let Some(at) = self.known.iter().position(|known| known.same_law(effect)) {
            return at;
        }
        self.known.push(effect.clone());
        self.known.len() - 1
    }

    fn add_point(&mut self, fitted: &Arc<FittedModel>) {
        let sites = sites_of(self.subject, fitted);
        let mut forces = gp_terms(self.subject, fitted, &sites);
        forces.extend(left_by_laws(self.subject, fitted, &sites));
        let further = forces
            .iter()
            .map(|force| force.hypothesis.clone())
            .collect();
        let mut model = EffectModel::new(self.subject, fitted, &sites, further);
        let modest = fitted.sizes.at(fitted.sizes.capped_above_median(0.0));
        let mut sizes = vec![fitted.sizes.clone()];
        if modest.ln != fitted.sizes.ln {
            sizes.push(modest);
        }
        let marginals: Vec<Marginal> = sizes
            .iter()
            .filter_map(|sizes| model.marginalised(sizes))
            .collect();
        let start: EffectSet = (0..model.own).collect();
        let is_first = self.points.is_empty();
        let pools = marginals
            .iter()
            .map(|marginal| Sets::new(&model, marginal).closure(&start, is_first))
            .collect();
        model.forget_products();
        let ids: Vec<usize> = model.effects.iter().map(|effect| self.id(effect)).collect();
        self.forces.extend(forces);
        self.points.push(Point {
            model,
            marginals,
            pools,
            ids,
        });
    }

    /// Converts a set to the effect indices of a linearisation point. Returns `None` if an effect of the set is not a candidate at that point.
    fn at_point(point: &Point, ids: &Ids) -> Option<EffectSet> {
        let own = |id: &usize| point.ids.iter().position(|other| other == id);
        let mut set = ids.iter().map(own).collect::<Option<EffectSet>>()?;
        set.sort_unstable();
        Some(set)
    }

    /// Estimates the log posterior of all probable sets that are not fitted. The estimate of the linear model is corrected by the error that the
    /// linear model has for the nearest fitted set. The correction decreases with the distance between the two predictions.
    fn estimates(&self) -> BTreeMap<Ids, SetEstimate> {
        let best = self.best();
        let mut out: BTreeMap<Ids, SetEstimate> = BTreeMap::new();
        for (p, point) in self.points.iter().enumerate() {
            for (r, (marginal, pool)) in point.marginals.iter().zip(&point.pools).enumerate() {
                let sets = Sets::new(&point.model, marginal);
                let mut references = Vec::new();
                let mut largest = 0.0_f64;
                let mut by_law: BTreeMap<RoughLaw, f64> = BTreeMap::new();
                for (ids, fit) in &self.fits {
                    let own = fit.ln_posterior;
                    if own < best - 3.0 * OCCAM_WINDOW_NATS {
                        continue;
                    }
                    let Some(set) = Self::at_point(point, ids) else {
                        continue;
                    };
                    let (Some(score), Some(parts)) = (sets.score(&set), sets.contributions(&set))
                    else {
                        continue;
                    };
                    let error = own - (marginal.ln_z + score);
                    largest = largest.max(error);
                    for law in new_rough_laws(&point.model, &set) {
                        let known = by_law.entry(law).or_insert(error);
                        *known = known.max(error);
                    }
                    references.push((parts, error));
                }
                for (set, score) in pool {
                    let linear = marginal.ln_z + score;
                    if linear + largest < best - OCCAM_WINDOW_NATS {
                        continue;
                    }
                    let mut ids: Ids = set.iter().map(|k| point.ids[*k]).collect();
                    ids.sort_unstable();
                    ids.dedup();
                    if ids.len() < set.len()
                        || self.fits.contains_key(&ids)
                        || self.discarded.contains(&ids)
                    {
                        continue;
                    }
                    let Some(parts) = sets.contributions(set) else {
                        continue;
                    };
                    let (mut distance, mut correction) = (f64::INFINITY, 0.0);
                    for (other, error) in &references {
                        let apart = sets.distance(&parts, other);
                        if apart < distance {
                            distance = apart;
                            correction = libm::exp(-0.5 * apart) * error;
                        }
                    }
                    // The linear model of a law is rough, in the same way for the same law at another place.
                    let of_law = new_rough_laws(&point.model, set).filter_map(|law| by_law.get(&law));
                    correction = of_law.fold(correction, |most, error| error.max(most));
                    let new = SetEstimate {
                        ln_posterior: linear + correction,
                        distance,
                        point: p,
                        marginal: r,
                        set: set.clone(),
                    };
                    let is_better = |old: &SetEstimate| {
                        if new.distance.min(old.distance) <= EQUIVALENT_DISTANCE {
                            new.distance < old.distance
                        } else {
                            new.ln_posterior > old.ln_posterior
                        }
                    };
                    if out.get(&ids).is_none_or(is_better) {
                        out.insert(ids, new);
                    }
                }
            }
        }
        out
    }

    /// Fits a set of effects, starting from the optimum of the linear model. Stores the fit, or discards the set if the fit fails.
    fn confirm(&mut self, ids: &Ids, estimate: &SetEstimate) {
        self.count += 1;
        let point = &self.points[estimate.point];
        let marginal = &point.marginals[estimate.marginal];
        let sets = Sets::new(&point.model, marginal);
        let set = &estimate.set;
        let Some(conditioned) = sets.conditioned(set) else {
            self.discarded.insert(ids.clone());
            return;
        };
        let x = point
            .model
            .start(marginal, &conditioned, MAX_LN_STIFFNESS_START);
        let guesses = |k: usize, start: usize| {
            let effect = &point.model.effects[k];
            match &point.model.scans[k] {
                Some(scan) => dry_friction::started(effect, &scan.starts[start]),
                None if k < point.model.own => (effect.clone(), vec![0.0; effect.numbers.len()]),
                None => {
                    let guesses = point.model.guesses(marginal, &conditioned, k);
                    (effect.clone(), guesses)
                }
            }
        };
        let is_scanned = set.iter().any(|k| point.model.scans[*k].is_some());
        let starts = if is_scanned { 2 } else { 1 };
        let parent = Arc::clone(&point.model.fitted);
        let ends = (0..starts).filter_map(|start| {
            let chosen: Vec<_> = set.iter().map(|k| guesses(*k, start)).collect();
            self.fit(&chosen, &parent, &x)
        });
        let found = ends.max_by(|a, b| a.ln_posterior().total_cmp(&b.ln_posterior()));
        let best = self.best();
        match found {
            Some(found) => self.note(ids, &found, best),
            None => {
                self.discarded.insert(ids.clone());
            }
        }
    }

    fn fit(
        &self,
        chosen: &[(CandidateEffect, Vec<f64>)],
        parent: &FittedModel,
        x: &[f64],
    ) -> Option<Arc<FittedModel>> {
        let effects: Vec<CandidateEffect> = chosen.iter().map(|(h, _)| h.clone()).collect();
        // What a law with memory promises rises while its slip length shortens.
        let stopping = if effects.iter().any(|effect| effect.memory.is_some()) {
            EarlyStopping::NONE
        } else {
            EarlyStopping {
                lead: self.best() - CandidateEffect::ln_prior_of(&effects),
            }
        };
        let one = |chosen: &[(CandidateEffect, Vec<f64>)], from: &FittedModel, x: &[f64]| {
            fit_with_early_stopping(self.subject, chosen, Some((from, x)), self.data, stopping)
        };
        let mut found = one(chosen, parent, x)?;
        // A force of unknown law is linearised again at the end of the fit, and the fit is repeated.
        let mut again = with_zero_guesses(&found);
        let mut has_force = false;
        for (effect, _) in &mut again {
            let force = self
                .forces
                .iter()
                .find(|force| force.hypothesis.same_form(effect));
            if let Some(force) = force {
                *effect = force.at(self.subject, &found);
                has_force = true;
            }
        }
        if has_force
            && let Some(second) = one(&again, &found, &found.x)
            && second.ln_posterior() > found.ln_posterior()
        {
            found = second;
        }
        let wrong = (0..found.effects.len()).any(|k| found.has_wrong_sign(k));
        (!wrong).then_some(found)
    }

    /// Stores a fit. A fit near the best becomes a further linearisation point. From that point, subsets of its effects are fitted again if the
    /// linear model predicts a higher log posterior than their earlier fits reached.
    fn note(&mut self, ids: &Ids, found: &Arc<FittedModel>, best: f64) {
        let own = found.ln_posterior();
        if self
            .fits
            .get(ids)
            .is_some_and(|old| old.ln_posterior >= own)
        {
            return;
        }
        if ids.is_empty() {
            self.none = Arc::clone(found);
        }
        self.fits.insert(ids.clone(), Fit::new(found));
        let least = best.max(own) - OCCAM_WINDOW_NATS;
        for fit in self.fits.values_mut() {
            if fit.ln_posterior < least {
                fit.model = None;
            }
        }
        if own < best - 0.5 * OCCAM_WINDOW_NATS || self.points.len() >= MAX_SELECTION_POINTS {
            return;
        }
        self.add_point(found);
        let at = self.points.len() - 1;
        let point = &self.points[at];
        let Some(marginal) = point.marginals.first() else {
            return;
        };
        let sets = Sets::new(&point.model, marginal);
        let best = self.best();
        let mut again = Vec::new();
        for (other, fit) in &self.fits {
            let is_subset = other.len() < ids.len() && other.iter().all(|id| ids.contains(id));
            if !is_subset {
                continue;
            }
            let Some(set) = Self::at_point(point, other) else {
                continue;
            };
            let Some(score) = sets.score(&set) else {
                continue;
            };
            let expected = marginal.ln_z + score;
            if expected > fit.ln_posterior + 1.0 && expected > best - OCCAM_WINDOW_NATS {
                again.push((other.clone(), set));
            }
        }
        for (ids, set) in again {
            let estimate = SetEstimate {
                ln_posterior: f64::NAN,
                distance: f64::NAN,
                point: at,
                marginal: 0,
                set,
            };
            self.confirm(&ids, &estimate);
        }
    }

    fn selected(&self) -> Selected {
        let best = self.best();
        let mut sets: Vec<ModelSet> = Vec::new();
        for fit in self.fits.values() {
            if let Some(fitted) = &fit.model
                && fit.ln_posterior > best - OCCAM_WINDOW_NATS
            {
                sets.push(ModelSet {
                    causes: fitted.effects.clone(),
                    ln_posterior: fit.ln_posterior,
                    fitted: Some(Arc::clone(fitted)),
                });
            }
        }
        for estimate in self.estimates().into_values() {
            let ln_posterior = estimate.ln_posterior.min(best);
            if ln_posterior > best - OCCAM_WINDOW_NATS {
                let effects = &self.points[estimate.point].model.effects;
                let causes = estimate.set.iter().flat_map(|k| effects[*k].split());
                sets.push(ModelSet {
                    causes: causes.collect(),
                    ln_posterior,
                    fitted: None,
                });
            }
        }
        let models = weighted(sets);
        let none = Arc::clone(&self.none);
        Selected {
            leading: leading(&models, &none),
            none,
            models,
            places: self
                .points
                .first()
                .map_or(0, |point| point.model.effects.len()),
            cut_short: self.count >= MAX_SELECTION_FITS || self.subject.budget_exhausted(),
        }
    }
}

/// Law whose linear model is rough.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum RoughLaw {
    /// Friction or creep. Each of them can look like the other.
    WithMemory,
    /// Law of any other cause.
    Of(Cause),
}

/// Returns the laws of the effects of a set that are not in the fit of the point.
fn new_rough_laws(model: &EffectModel, set: &[usize]) -> impl Iterator<Item = RoughLaw> {
    let new = set.iter().filter(|k| **k >= model.own);
    new.filter_map(|k| {
        let effect = &model.effects[*k];
        if effect.memory.is_some() {
            return Some(RoughLaw::WithMemory);
        }
        let is_rough = effect.is_poorly_linearised();
        is_rough.then_some(RoughLaw::Of(effect.cause))
    })
}

/// Returns the fit that is reported. It is the most probable fitted set; if some cause acts with a probability above one half, the most probable
/// fitted set with a cause. Its effects that are less probable than not, with all that cannot be told from them, are left out if the set without
/// them is fitted, too.
fn leading(models: &[(ModelSet, f64)], none: &Arc<FittedModel>) -> Arc<FittedModel> {
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
