//! Selection of effects. Linear models propose probable sets of effects, and full fits confirm them, the most probable set first. The selection
//! ends when every set that is probable enough is fitted, or predicts the same as a fitted set, or when the budget is spent.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::candidate_effect::CandidateEffect;
use super::challengers::{Challenger, Reason, challengers};
use super::closure::{EffectSet, Sets};
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::early_stopping::EarlyStopping;
use super::fit::{FittedModel, fit_with_early_stopping, with_zero_guesses};
use super::fitted_set::FittedSet;
use super::model_set::{ModelSet, Selected, leading, weighted};
use super::point::{Forms, Ids, Point};
use super::reduction::{EffectModel, Marginal};
use super::remainder::{GpTerm, gp_terms, left_by_laws, sites_of};
use super::set_estimate::{SetEstimate, estimates};
use super::settings::{
    CONVERGED_NATS, EQUIVALENT_DISTANCE, MAX_LN_STIFFNESS_START, MAX_SELECTION_FITS,
    MAX_SELECTION_POINTS, OCCAM_WINDOW_NATS, RESOLVED_PROBABILITY,
};

/// Rule by which a fit becomes a linearisation point.
#[derive(Clone, Copy, PartialEq, Eq)]
enum BecomesPoint {
    Always,
    IfProbable,
    /// Only if the fit leads clearly.
    IfLeading,
}

struct Selector<'a, 'b> {
    /// Fit without effects.
    none: Arc<FittedModel>,
    subject: &'a DiagnosisProblem<'b>,
    data: Data,
    known: Vec<CandidateEffect>,
    /// Forces of unknown law that were candidates at a linearisation point.
    forces: Vec<GpTerm>,
    fits: BTreeMap<Ids, FittedSet>,
    /// Sets that are not fitted again: their fit failed, or an effect had the wrong sign.
    discarded: BTreeSet<Ids>,
    /// Sets whose fit did not improve when it was repeated from another linearisation point.
    settled: BTreeSet<Ids>,
    /// Linearisation points: the fit without effects, and the most probable of the other fits.
    points: Vec<Arc<Point>>,
    /// Sets that the fit of a point must be compared with if it leads, for each point.
    challengers: Vec<(Arc<FittedModel>, Vec<Challenger>)>,
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
        settled: BTreeSet::new(),
        points: Vec::new(),
        challengers: Vec::new(),
        count: 1,
    };
    selector
        .fits
        .entry(Vec::new())
        .or_default()
        .add(Forms::new(), none);
    selector.add_point(none);
    selector.run();
    selector.selected()
}

impl Selector<'_, '_> {
    fn run(&mut self) {
        loop {
            self.confirm_estimates();
            if !self.challenge(false) {
                break;
            }
        }
    }

    fn may_continue(&self) -> bool {
        self.count < MAX_SELECTION_FITS
            && !self.subject.budget_exhausted()
            && !self.subject.progress().is_stopped()
    }

    /// Fits sets until the posterior of every sufficiently probable set is known. Sets with the fewest effects come first, because their linear
    /// model has the smallest error; among them, the most probable set comes first. A set that predicts the same as a fitted set is fitted only
    /// if its estimate exceeds all fits.
    fn confirm_estimates(&mut self) {
        while self.may_continue() {
            if self.challenge(true) {
                continue;
            }
            let best = self.best();
            let least = best + libm::log(RESOLVED_PROBABILITY);
            let open = self.estimates().into_iter().filter(|(_, estimate)| {
                estimate.ln_posterior > least
                    && (estimate.distance > EQUIVALENT_DISTANCE
                        || estimate.ln_posterior > best + CONVERGED_NATS)
            });
            let next = open.min_by(|(_, a), (_, b)| {
                let by_size = a.set.len().cmp(&b.set.len());
                by_size.then(b.ln_posterior.total_cmp(&a.ln_posterior))
            });
            let Some((ids, estimate)) = next else { break };
            self.confirm(&ids, &estimate, BecomesPoint::IfProbable);
        }
    }

    /// Fits the sets that the leading fit must be compared with. If `only_laws` is true, fits only the sets in which a law of the catalogue
    /// replaces a force of unknown law. Returns true if any set was fitted.
    fn challenge(&mut self, only_laws: bool) -> bool {
        let count = self.count;
        let fits = self.fits.values();
        let leading = fits.max_by(|a, b| a.ln_posterior().total_cmp(&b.ln_posterior()));
        let Some(leading) = leading.and_then(|fit| fit.model().cloned()) else {
            return false;
        };
        let is_own = |point: &&Arc<Point>| Arc::ptr_eq(&point.model.fitted, &leading);
        let Some(point) = self.points.iter().find(is_own).cloned() else {
            return false;
        };
        let mut all = self.challengers.iter_mut();
        let of_leading = all.find(|(fitted, _)| Arc::ptr_eq(fitted, &leading));
        let open = of_leading.map_or_else(Vec::new, |(_, open)| {
            let is_due = |c: &mut Challenger| !only_laws || c.reason == Reason::KnownLaw;
            open.extract_if(.., is_due).collect()
        });
        for Challenger {
            set,
            reason,
            expected,
        } in open
        {
            let ids = point.ids_of(&set);
            let model = &point.model;
            let is_new_law = |k: &usize| *k >= model.own && model.effects[*k].memory.is_some();
            // The fit of a law with memory may have stopped early at another start.
            let may_stop_early =
                matches!(reason, Reason::Rival | Reason::UnusualSize) && set.iter().any(is_new_law);
            let forms = point.forms_of(&set);
            let of_set = self.fits.get(&ids);
            let is_settled = of_set.is_some_and(|fits| match reason {
                Reason::OtherFunction => fits.holds(&forms),
                _ => !may_stop_early,
            });
            if is_settled || self.discarded.contains(&ids) {
                continue;
            }
            // A new leading fit has challengers of its own.
            let fits = self.fits.values().filter_map(FittedSet::model);
            let best = fits
                .map(|fit| fit.ln_posterior())
                .fold(f64::NEG_INFINITY, f64::max);
            if !self.may_continue() || best > leading.ln_posterior() + CONVERGED_NATS {
                break;
            }
            let estimate = SetEstimate {
                ln_posterior: expected,
                distance: f64::NAN,
                point: Arc::clone(&point),
                marginal: 0,
                set,
            };
            let becomes = match reason {
                // The linear model of the remaining effects shows what else can take the place of the omitted one.
                Reason::KnownLaw | Reason::LeftOut => BecomesPoint::Always,
                Reason::Rival => BecomesPoint::IfLeading,
                _ => BecomesPoint::IfProbable,
            };
            self.confirm(&ids, &estimate, becomes);
        }
        if !only_laws {
            self.fit_rivals(&leading);
        }
        self.count > count
    }

    /// Fits the probable sets in which another cause replaces one cause of the leading set. Such a set is fitted even if it predicts the same
    /// readings as the leading fit, because its estimate then depends on the leading fit.
    fn fit_rivals(&mut self, leading: &FittedModel) {
        let least = leading.ln_posterior() + libm::log(RESOLVED_PROBABILITY);
        let own: Ids = leading
            .effects
            .iter()
            .map(|effect| self.id(effect))
            .collect();
        let open = self.estimates().into_iter().filter(|(ids, estimate)| {
            let shared = ids.iter().filter(|id| own.contains(id)).count();
            estimate.ln_posterior > least && ids.len() == own.len() && shared + 1 == own.len()
        });
        let mut open: Vec<(Ids, SetEstimate)> = open.collect();
        open.sort_by(|a, b| b.1.ln_posterior.total_cmp(&a.1.ln_posterior));
        for (ids, estimate) in open {
            if self.may_continue() {
                self.confirm(&ids, &estimate, BecomesPoint::IfProbable);
            }
        }
    }

    fn best(&self) -> f64 {
        let all = self.fits.values().map(FittedSet::ln_posterior);
        all.fold(f64::NEG_INFINITY, f64::max)
    }

    fn id(&mut self, effect: &CandidateEffect) -> usize {
        if let Some(at) = self
            .known
            .iter()
            .position(|known| known.is_same_effect(effect))
        {
            return at;
        }
        self.known.push(effect.clone());
        self.known.len() - 1
    }

    /// Adds a linearisation point at a fit, with the probable sets of its linear model.
    fn add_point(&mut self, fitted: &Arc<FittedModel>) -> Arc<Point> {
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
        if let Some(marginal) = marginals.first() {
            model.correct_held_laws(marginal);
        }
        let start: EffectSet = (0..model.own).collect();
        let is_first = self.points.is_empty();
        let pools = marginals
            .iter()
            .map(|marginal| {
                let sets = Sets::new(&model, marginal);
                let mut pool = sets.closure(&start, is_first);
                pool.extend(sets.neighbours(&start));
                pool
            })
            .collect();
        let challengers = marginals
            .first()
            .map(|marginal| challengers(&model, marginal));
        model.forget_products();
        let terms = |effect: &CandidateEffect| -> Ids {
            let terms = effect.split();
            terms.iter().map(|term| self.id(term)).collect()
        };
        let ids = model.effects.iter().map(terms).collect();
        self.forces.extend(forces);
        self.challengers
            .push((Arc::clone(fitted), challengers.unwrap_or_default()));
        let new = Arc::new(Point {
            model,
            marginals,
            pools,
            ids,
        });
        self.points.push(Arc::clone(&new));
        if self.points.len() > MAX_SELECTION_POINTS {
            self.drop_least_probable_point();
        }
        new
    }

    /// Drops the least probable linearisation point. The fit without effects stays.
    fn drop_least_probable_point(&mut self) {
        let others = self.points.iter().enumerate().skip(1);
        let probability = |point: &Point| point.model.fitted.ln_posterior();
        let least = others.min_by(|(_, a), (_, b)| probability(a).total_cmp(&probability(b)));
        if let Some((at, _)) = least {
            let dropped = self.points.remove(at);
            let fitted = &dropped.model.fitted;
            self.challengers
                .retain(|(own, _)| !Arc::ptr_eq(own, fitted));
        }
    }

    fn estimates(&self) -> BTreeMap<Ids, SetEstimate> {
        estimates(&self.points, &self.fits, &self.discarded)
    }

    /// Fits a set of effects, starting from the optimum of the linear model. Stores the fit, or discards the set if the fit fails.
    fn confirm(&mut self, ids: &Ids, estimate: &SetEstimate, becomes: BecomesPoint) {
        self.count += 1;
        let point = &estimate.point;
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
        let starts: Vec<Vec<(CandidateEffect, Vec<f64>)>> = set
            .iter()
            .map(|k| {
                point.starts(*k, |form| {
                    let with = |own: &usize| if own == k { form } else { *own };
                    let set: EffectSet = set.iter().map(with).collect();
                    let conditioned = sets.conditioned(&set);
                    conditioned.map_or_else(
                        || vec![0.0; point.model.effects[form].numbers.len()],
                        |conditioned| point.model.guesses(marginal, &conditioned, form),
                    )
                })
            })
            .collect();
        let count = starts.iter().map(Vec::len).max().unwrap_or(1);
        let parent = Arc::clone(&point.model.fitted);
        let ends = (0..count).filter_map(|start| {
            let of = |starts: &Vec<(CandidateEffect, Vec<f64>)>| {
                starts.get(start).or(starts.last()).cloned()
            };
            let chosen: Vec<_> = starts.iter().filter_map(of).collect();
            self.fit(&chosen, &parent, &x)
        });
        let mut found: Vec<Arc<FittedModel>> = ends.collect();
        found.sort_by(|a, b| b.ln_posterior().total_cmp(&a.ln_posterior()));
        // Kinks of a law with memory may stop a fit early; a new start may pass them.
        if let Some(end) = found.first()
            && end.effects.iter().any(|effect| effect.memory.is_some())
            && end.ln_posterior() + CONVERGED_NATS < estimate.ln_posterior
            && let Some(again) = self.fit(&with_zero_guesses(end), end, &end.x)
            && again.ln_posterior() > end.ln_posterior()
        {
            found.insert(0, again);
        }
        if found.is_empty() && !self.fits.contains_key(ids) {
            self.discarded.insert(ids.clone());
        }
        let best = self.best();
        // The most probable fit comes first, so that it alone can become a linearisation point.
        for fitted in found {
            self.note(ids, &fitted, best, becomes);
        }
    }

    fn fit(
        &self,
        chosen: &[(CandidateEffect, Vec<f64>)],
        parent: &FittedModel,
        x: &[f64],
    ) -> Option<Arc<FittedModel>> {
        let effects: Vec<CandidateEffect> = chosen.iter().map(|(h, _)| h.clone()).collect();
        // The predicted evidence of a law with memory rises while its slip length shortens, so its fit is not stopped early.
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
    fn note(&mut self, ids: &Ids, found: &Arc<FittedModel>, best: f64, becomes: BecomesPoint) {
        let own = found.ln_posterior();
        let each = found.effects.iter();
        let forms = each.map(|effect| (self.id(effect), effect.form)).collect();
        let fits = self.fits.entry(ids.clone()).or_default();
        if !fits.add(forms, found) {
            return;
        }
        if ids.is_empty() {
            self.none = Arc::clone(found);
        }
        let least = best.max(own) - OCCAM_WINDOW_NATS;
        self.forget(least);
        let is_point = match becomes {
            BecomesPoint::Always => true,
            BecomesPoint::IfProbable => own >= best - 0.5 * OCCAM_WINDOW_NATS,
            BecomesPoint::IfLeading => own > best + CONVERGED_NATS,
        };
        if !is_point {
            return;
        }
        let point = self.add_point(found);
        let Some(marginal) = point.marginals.first() else {
            return;
        };
        let sets = Sets::new(&point.model, marginal);
        let best = self.best();
        let mut again = Vec::new();
        for (other, fit) in &self.fits {
            let is_subset = other.len() < ids.len() && other.iter().all(|id| ids.contains(id));
            if !is_subset || self.settled.contains(other) {
                continue;
            }
            let Some(set) = point.set_of(other, &Forms::new()) else {
                continue;
            };
            let Some(score) = sets.score(&set) else {
                continue;
            };
            let expected = marginal.ln_z + score;
            if expected > fit.ln_posterior() + 1.0 && expected > best - OCCAM_WINDOW_NATS {
                again.push((other.clone(), set));
            }
        }
        for (ids, set) in again {
            let estimate = SetEstimate {
                ln_posterior: f64::NAN,
                distance: f64::NAN,
                point: Arc::clone(&point),
                marginal: 0,
                set,
            };
            if !self.may_continue() {
                break;
            }
            let known = self.fits[&ids].ln_posterior();
            self.confirm(&ids, &estimate, BecomesPoint::IfProbable);
            if self.fits[&ids].ln_posterior() < known + CONVERGED_NATS {
                self.settled.insert(ids);
            }
        }
    }

    /// Frees the fits whose log posterior is below `least`. Fits of subsets of a more probable set are kept: a comparison with them shows the gain
    /// by the other effects of that set.
    fn forget(&mut self, least: f64) {
        let probable: Vec<Ids> = self
            .fits
            .iter()
            .filter(|(_, fit)| fit.ln_posterior() >= least)
            .map(|(ids, _)| ids.clone())
            .collect();
        for (ids, fits) in &mut self.fits {
            let is_within = |of: &Ids| ids.iter().all(|id| of.contains(id));
            if !probable.iter().any(is_within) {
                fits.forget(least);
            }
        }
    }

    fn selected(&self) -> Selected {
        let best = self.best();
        let mut sets: Vec<ModelSet> = Vec::new();
        for (fitted, ln_posterior) in self.fits.values().flat_map(FittedSet::models) {
            if ln_posterior > best - OCCAM_WINDOW_NATS {
                sets.push(ModelSet {
                    causes: fitted.effects.clone(),
                    ln_posterior,
                    fitted: Some(Arc::clone(fitted)),
                });
            }
        }
        for estimate in self.estimates().into_values() {
            let ln_posterior = estimate.ln_posterior.min(best);
            if ln_posterior > best - OCCAM_WINDOW_NATS {
                let effects = &estimate.point.model.effects;
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
            fits: self
                .fits
                .values()
                .flat_map(FittedSet::models)
                .map(|(fitted, _)| Arc::clone(fitted))
                .collect(),
            places: self
                .points
                .first()
                .map_or(0, |point| point.model.effects.len()),
            cut_short: self.count >= MAX_SELECTION_FITS || self.subject.budget_exhausted(),
        }
    }
}
