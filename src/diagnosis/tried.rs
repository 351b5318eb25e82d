//! Models that were fitted on the way of a search.

use std::sync::Arc;

use super::candidate_effect::{CandidateEffect, EffectParameter, Parametrisation, Term};
use super::cause::Cause;
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::ends::{Ends, Start};
use super::fit::{
    EarlyStopping, FitOutcome, FittedModel, fit_with_early_stopping, with_zero_guesses,
};
use super::scan::Weighed;
use super::visited::{Visited, same_laws, same_set};
use admire_identify::tolerance::VarianceComponents;

/// Slip lengths are tried again at these parts of themselves.
const SLIPS: [f64; 2] = [0.4, 2.0];
/// A fit that ends so many nats below the model without the cause went astray; it begins again with so much of the guesses.
const ASTRAY: f64 = 30.0;
const SMALL: f64 = 0.1;
/// A fit that could go no further is stuck if it promises so many nats and would lead with them; it begins anew from the deck.
const STUCK: f64 = 10.0;
/// A model has to be better by so many nats.
pub(super) const BETTER: f64 = 0.05;

/// What was tried on some cases.
pub(super) struct Tried<'a, 'b> {
    pub subject: &'a DiagnosisProblem<'b>,
    pub data: Data,
    /// All models that were looked at.
    pub visited: Vec<Visited>,
    /// Models as a search of other cases fitted them.
    pub elsewhere: Vec<Arc<FittedModel>>,
    /// Fits that began at others, and those.
    begun: Vec<(Arc<FittedModel>, Arc<FittedModel>)>,
    /// Models, a cause more, and the fit with it.
    added: Vec<(Arc<FittedModel>, CandidateEffect, Arc<FittedModel>)>,
    /// The same where the cause came out with the wrong sign.
    wrong: Vec<(Arc<FittedModel>, CandidateEffect, Arc<FittedModel>)>,
    /// Models, and further sliders that began with half of a force there.
    halved: Vec<(Arc<FittedModel>, CandidateEffect)>,
    /// How all fits ended.
    ends: Ends,
}

impl<'a, 'b> Tried<'a, 'b> {
    /// Nothing yet.
    pub(super) fn new(subject: &'a DiagnosisProblem<'b>, data: Data) -> Self {
        Self {
            subject,
            data,
            visited: Vec::new(),
            elsewhere: Vec::new(),
            begun: Vec::new(),
            added: Vec::new(),
            wrong: Vec::new(),
            ends: Ends::default(),
            halved: Vec::new(),
        }
    }

    /// A fit for a target, with the `sizes` of tolerances given or else those of `from`. One that was made from the same start is not made
    /// again.
    pub(super) fn fitted(
        &mut self,
        causes: &[(CandidateEffect, Vec<f64>)],
        from: Option<(&FittedModel, &[f64])>,
        sizes: Option<&VarianceComponents>,
        target: EarlyStopping<'_>,
    ) -> Option<FitOutcome> {
        let start = Start::new(causes, from, sizes);
        if let Some(known) = self.ends.of(&start, &target) {
            return known.fit.clone();
        }
        let fit = fit_with_early_stopping(self.subject, causes, from, sizes, self.data, target);
        self.ends.note(start, &target, fit.as_ref());
        fit
    }

    /// The same without a target.
    pub(super) fn settled(
        &mut self,
        causes: &[(CandidateEffect, Vec<f64>)],
        from: Option<(&FittedModel, &[f64])>,
    ) -> Option<Arc<FittedModel>> {
        match self.fitted(causes, from, None, EarlyStopping::NONE)? {
            FitOutcome::New(found) => Some(found),
            FitOutcome::Duplicate => None,
        }
    }

    /// Counts a fit among the models that were looked at.
    pub(super) fn note(&mut self, fitted: &Arc<FittedModel>) {
        self.visited.push(Visited {
            causes: fitted.effects.clone(),
            ln_posterior: fitted.ln_posterior(),
            fitted: Some(Arc::clone(fitted)),
        });
    }

    /// Fits `base` with one more cause, as long as it may come near to `lead` nats, prior included. A fit that leads to the end of
    /// another start of the same law counts as that one. `None` where the cause comes out with the wrong sign.
    pub(super) fn with(
        &mut self,
        base: &Arc<FittedModel>,
        (h, weighed): (&CandidateEffect, &Weighed),
        lead: f64,
    ) -> Option<Arc<FittedModel>> {
        let of_base = self.added.iter().filter(|(of, ..)| Arc::ptr_eq(of, base));
        let mut of_base = of_base.map(|(_, added, found)| (added, found));
        if let Some((_, known)) = of_base.clone().find(|(added, _)| added.same_form(h)) {
            return Some(Arc::clone(known));
        }
        let known = of_base.find(|(added, _)| added.same_law(h));
        let known = known.map(|(_, found)| Arc::clone(found));
        let mut wrong = self.wrong.iter();
        let wrong = wrong.find(|(of, added, _)| Arc::ptr_eq(of, base) && added.same_law(h));
        let wrong = wrong.map(|(.., found)| Arc::clone(found));
        let target = EarlyStopping {
            lead: lead - base.ln_prior() - h.ln_prior_given(&base.effects),
            known: known.as_deref().or(wrong.as_deref()),
            ..EarlyStopping::NONE
        };
        // Forms of a slider that differ in their first guess come to the same here.
        let halves = halved(base, h).filter(|(half, ..)| {
            let same = |(of, known): &(Arc<FittedModel>, CandidateEffect)| {
                Arc::ptr_eq(of, base) && known.same_law(half)
            };
            !self.halved.iter().any(same)
        });
        if let Some((half, ..)) = &halves {
            self.halved.push((Arc::clone(base), half.clone()));
        }
        let found = match self.added_to(base, (h, weighed), halves, target) {
            Some(FitOutcome::New(found)) => {
                let is_wrong = found.has_wrong_sign(base.effects.len());
                if is_wrong && found.is_converged() {
                    let wrong = (Arc::clone(base), h.clone(), Arc::clone(&found));
                    self.wrong.push(wrong);
                }
                (!is_wrong).then_some(found)
            }
            Some(FitOutcome::Duplicate) => known,
            None => None,
        };
        let found = self.continued(base, h, found, lead)?;
        if found.is_converged() {
            let known = (Arc::clone(base), h.clone(), Arc::clone(&found));
            self.added.push(known);
        }
        self.visited.push(Visited {
            causes: found.effects.clone(),
            ln_posterior: found.ln_posterior(),
            fitted: Some(Arc::clone(&found)),
        });
        Some(found)
    }

    /// The better of a fit of `base` with friction and one that begins where a search of other cases ended with the same causes: that one
    /// may have crossed kinks for it.
    fn continued(
        &mut self,
        base: &FittedModel,
        h: &CandidateEffect,
        found: Option<Arc<FittedModel>>,
        lead: f64,
    ) -> Option<Arc<FittedModel>> {
        // Forms of a slider differ in their first guess.
        let own = |fit: &FittedModel| fit.effects.iter().position(|other| other.same_law(h));
        let is_same = |fit: &&Arc<FittedModel>| {
            let is_held = |h: &CandidateEffect| fit.effects.iter().any(|other| other.same_form(h));
            h.memory.is_some()
                && fit.is_converged()
                && fit.effects.len() == base.effects.len() + 1
                && base.effects.iter().all(is_held)
                && own(fit).is_some()
        };
        let same = self.elsewhere.iter().filter(is_same);
        let start = same.max_by(|a, b| a.ln_posterior().total_cmp(&b.ln_posterior()));
        let Some((start, at)) = start.and_then(|start| Some((Arc::clone(start), own(start)?)))
        else {
            return found;
        };
        let mut all = with_zero_guesses(base);
        let h = &start.effects[at];
        all.push((h.clone(), vec![0.0; h.numbers.len()]));
        let target = EarlyStopping {
            lead: lead - base.ln_prior() - h.ln_prior_given(&base.effects),
            known: found.as_deref(),
            ..EarlyStopping::NONE
        };
        let from = Some((&*start, start.x.as_slice()));
        let again = match self.fitted(&all, from, None, target) {
            Some(FitOutcome::New(again)) if !again.has_wrong_sign(all.len() - 1) => again,
            _ => return found,
        };
        match found {
            Some(found) if found.ln_posterior() >= again.ln_posterior() => Some(found),
            _ => Some(again),
        }
    }

    /// The fit with one more cause begun anew from the deck, where `found` could go no further though it would lead with what it
    /// promises: stiffnesses that make up for the cause in the model without it may lead into a valley that does not lead back. `None`
    /// where that is no better.
    pub(super) fn anew(
        &mut self,
        (base, found): (&FittedModel, &FittedModel),
        (h, weighed): (&CandidateEffect, &Weighed),
        lead: f64,
    ) -> Option<Arc<FittedModel>> {
        let promise = found.posterior.ln_z + found.ln_prior();
        if found.posterior.gain < STUCK || promise < lead || h.joint_with.is_some() {
            return None;
        }
        let mut all = with_zero_guesses(base);
        all.push((h.clone(), weighed.guesses.clone()));
        let target = EarlyStopping {
            lead: lead - found.ln_prior(),
            ..EarlyStopping::NONE
        };
        let Some(FitOutcome::New(again)) = self.fitted(&all, None, None, target) else {
            return None;
        };
        let is_better = again.ln_posterior() > found.ln_posterior();
        if !is_better || again.has_wrong_sign(base.effects.len()) {
            return None;
        }
        self.note(&again);
        Some(again)
    }

    /// The fit with one more cause, begun where the linear model puts it.
    fn added_to(
        &mut self,
        base: &FittedModel,
        (h, weighed): (&CandidateEffect, &Weighed),
        halved: Option<Halved>,
        target: EarlyStopping<'_>,
    ) -> Option<FitOutcome> {
        let mut begun =
            |h: &CandidateEffect, guesses: &[f64], x: &[f64], target: EarlyStopping<'_>| {
                let mut all = with_zero_guesses(base);
                all.push((h.clone(), guesses.to_vec()));
                self.fitted(&all, Some((base, x)), Some(&weighed.sizes), target)
            };
        let alone = EarlyStopping {
            known: None,
            ..target
        };
        let guesses = &weighed.guesses;
        // With the cause in the model it cannot be far worse than without.
        let least = base.ln_posterior() - ASTRAY;
        // A law that promises nothing and begins so far below has a guess that is out of the reach of the linear model. Friction has kinks
        // on its way.
        let is_promised = weighed.ln_posterior > base.ln_posterior();
        // With a further part the linear model promises more than it can keep.
        let is_rough = h.is_poorly_linearised() && h.memory.is_none() && !is_promised;
        let begin = if is_rough || h.joint_with.is_some() {
            least - base.ln_prior()
        } else {
            f64::NEG_INFINITY
        };
        // If the step of the linear model leads astray, begin where the fit without the cause ended.
        let found = match begun(h, guesses, &weighed.x, target.above(begin)) {
            Some(FitOutcome::Duplicate) => return Some(FitOutcome::Duplicate),
            Some(FitOutcome::New(found)) => Some(found),
            None => None,
        };
        let mut anew =
            |h: &CandidateEffect, guesses: &[f64], x: &[f64], target: EarlyStopping<'_>| {
                let found = begun(h, guesses, x, target)?;
                match found {
                    FitOutcome::New(fitted) => Some(fitted),
                    FitOutcome::Duplicate => None,
                }
            };
        // The linear model knows a smooth effect well: where it promises nothing, no other start makes up for so much.
        let is_smooth = !h.cause.has_rough_law() && h.cause != Cause::FreePlay;
        let is_vain =
            |found: &FittedModel| is_smooth && !is_promised && found.ln_posterior() < least;
        let is_done = |found: &FittedModel| {
            is_vain(found)
                || found.is_converged()
                || found.ln_posterior() > base.ln_posterior()
                || (target.is_beaten(found) && found.ln_posterior() > least)
        };
        let reached = |f: &Option<Arc<FittedModel>>| f.as_ref().map(|f| f.ln_posterior());
        let found = match found {
            Some(found) if is_done(&found) => Some(found),
            astray => {
                let again = anew(h, guesses, &base.x, alone.above(begin));
                if reached(&again) > reached(&astray) {
                    again
                } else {
                    astray
                }
            }
        };
        // What the linear model promises of a large effect may be out of its reach.
        let found = match found {
            Some(found) if found.ln_posterior() < least && !is_vain(&found) => {
                let small: Vec<f64> = guesses.iter().map(|guess| SMALL * guess).collect();
                let again = anew(h, &small, &base.x, alone);
                if reached(&again) > Some(found.ln_posterior()) {
                    again
                } else {
                    Some(found)
                }
            }
            found => found,
        };
        // A further slider takes over a part of what the first one does.
        let halved = halved.and_then(|(h, guesses, x)| anew(&h, &guesses, &x, alone));
        let found = match (found, halved) {
            (Some(a), Some(b)) if b.ln_posterior() > a.ln_posterior() => b,
            (a, b) => a.or(b)?,
        };
        let last = found.effects.len() - 1;
        let first = found.parameter_index[last]
            .first()
            .map_or(0.0, |at| found.x[*at]);
        if h.one_sided && first < 0.0 && guesses.iter().skip(1).any(|guess| *guess != 0.0) {
            // A force that can only push came out pulling: a higher term took the place of the first. Begin with the first term alone.
            let mut one_term = vec![0.0; guesses.len()];
            one_term[0] = guesses.iter().map(|g| g.abs()).sum();
            let again = anew(h, &one_term, &weighed.x, alone).filter(|again| {
                !again.has_wrong_sign(last)
                    && (found.has_wrong_sign(last) || again.ln_posterior() > found.ln_posterior())
            });
            if let Some(again) = again {
                return Some(FitOutcome::New(again));
            }
        }
        Some(FitOutcome::New(found))
    }

    /// The best fits with friction at other places beside a model than a winner's, if no worse than `least`.
    pub(super) fn beside(
        &self,
        base: &Arc<FittedModel>,
        winner: &FittedModel,
        least: f64,
    ) -> Vec<Arc<FittedModel>> {
        let mut out: Vec<(&CandidateEffect, Arc<FittedModel>)> = Vec::new();
        for (of, h, found) in &self.added {
            let is_winner = winner.effects.last().is_some_and(|own| own.same_site(h));
            if !Arc::ptr_eq(of, base)
                || h.memory.is_none()
                || is_winner
                || found.ln_posterior() < least
            {
                continue;
            }
            match out.iter_mut().find(|(known, _)| known.same_site(h)) {
                Some((_, known)) if known.ln_posterior() >= found.ln_posterior() => {}
                Some((_, known)) => *known = Arc::clone(found),
                None => out.push((h, Arc::clone(found))),
            }
        }
        out.into_iter().map(|(_, found)| found).collect()
    }

    /// Fits models with friction anew from slip lengths on both sides of where they ended: sliders that stick or slip in another case
    /// lie beyond kinks that no step crosses.
    pub(super) fn restarted(&mut self, mut current: Arc<FittedModel>) -> Arc<FittedModel> {
        for at in 0..current.effects.len() {
            let numbers = current.effects[at].numbers.iter();
            let mut lengths = numbers.zip(&current.parameter_index[at]);
            let is_length = |(n, _): &(&EffectParameter, &usize)| {
                matches!(n.unknown, Parametrisation::SlipLength { .. })
            };
            let Some(place) = lengths.find(is_length).map(|(_, place)| *place) else {
                continue;
            };
            for factor in SLIPS {
                let mut x = current.x.clone();
                x[place] += libm::log(factor);
                let chosen = with_zero_guesses(&current);
                let target = EarlyStopping::beyond(&current);
                let from = Some((&*current, x.as_slice()));
                let Some(FitOutcome::New(found)) = self.fitted(&chosen, from, None, target) else {
                    continue;
                };
                let is_better = found.ln_posterior() > current.ln_posterior() + BETTER;
                if is_better && !found.has_wrong_sign(at) {
                    current = found;
                    self.note(&current);
                }
            }
        }
        current
    }

    /// The best fit of a model that was fitted to its end already.
    pub(super) fn known(&self, causes: &[CandidateEffect]) -> Option<Arc<FittedModel>> {
        let same = self.visited.iter().filter(|v| same_laws(&v.causes, causes));
        let fitted = same.filter_map(|v| v.fitted.as_ref().filter(|f| f.is_converged()));
        let better = |a: &&Arc<FittedModel>, b: &&Arc<FittedModel>| {
            a.ln_posterior().total_cmp(&b.ln_posterior())
        };
        fitted.max_by(better).cloned()
    }

    /// Fits a model without one of its causes, or without a further part of its law. No such part stays without the first one.
    pub(super) fn without(
        &mut self,
        fitted: &Arc<FittedModel>,
        at: usize,
    ) -> Option<Arc<FittedModel>> {
        let dropped = &fitted.effects[at];
        let is_dropped = |(k, h): &(usize, &CandidateEffect)| {
            *k == at || (dropped.term == Term::Main && h.term > Term::Main && h.same_site(dropped))
        };
        let kept = fitted
            .effects
            .iter()
            .enumerate()
            .filter(|of| !is_dropped(of));
        let causes: Vec<CandidateEffect> = kept.map(|(_, h)| h.clone()).collect();
        if causes.is_empty() {
            return None;
        }
        self.of(fitted, causes)
    }

    /// A model without a cause and the further parts of its law; `none` where nothing else is in it. `None` for such a part.
    pub(super) fn without_all_parts(
        &mut self,
        fitted: &Arc<FittedModel>,
        at: usize,
        none: &Arc<FittedModel>,
    ) -> Option<Arc<FittedModel>> {
        let own = &fitted.effects[at];
        if own.term > Term::Main {
            return None;
        }
        let others = fitted.effects.iter().filter(|h| !h.same_site(own));
        let others: Vec<CandidateEffect> = others.cloned().collect();
        if others.is_empty() {
            return Some(Arc::clone(none));
        }
        self.of(fitted, others)
    }

    /// The fit without one cause, refitted from where the model with the cause ended if that is better. What replaces the cause is compared with a fit
    /// that has come as far.
    pub(super) fn without_refitted(
        &mut self,
        fitted: &Arc<FittedModel>,
        at: usize,
    ) -> Option<Arc<FittedModel>> {
        let known = self.without(fitted, at)?;
        let is_from_here = |(found, from): &(Arc<FittedModel>, Arc<FittedModel>)| {
            Arc::ptr_eq(from, fitted) && same_set(&found.effects, &known.effects)
        };
        if self.begun.iter().any(is_from_here) {
            return Some(known);
        }
        let mut all = with_zero_guesses(fitted);
        all.remove(at);
        let from = Some((&**fitted, fitted.x.as_slice()));
        let target = EarlyStopping::beyond(&known);
        let again = match self.fitted(&all, from, None, target) {
            Some(FitOutcome::New(again))
                if again.ln_posterior() > known.ln_posterior() + BETTER =>
            {
                again
            }
            _ => return Some(known),
        };
        self.note(&again);
        Some(again)
    }

    /// The model of some of the causes of a fit. Where it is not known it is fitted from where a fit of the same causes to other cases
    /// ended, or from where that of all of them did.
    pub(super) fn of(
        &mut self,
        fitted: &Arc<FittedModel>,
        causes: Vec<CandidateEffect>,
    ) -> Option<Arc<FittedModel>> {
        if let Some(known) = self.known(&causes) {
            return Some(known);
        }
        // One that did not come to an end would not do so from the same start.
        let is_again = |(found, from): &&(Arc<FittedModel>, Arc<FittedModel>)| {
            Arc::ptr_eq(from, fitted) && same_laws(&found.effects, &causes)
        };
        if let Some((known, _)) = self.begun.iter().find(is_again) {
            return Some(Arc::clone(known));
        }
        let zeros = |h: CandidateEffect| {
            let count = h.numbers.len();
            (h, vec![0.0; count])
        };
        let of_laws = |f: &&Arc<FittedModel>| f.is_converged() && same_laws(&f.effects, &causes);
        let elsewhere = self.elsewhere.iter().find(of_laws);
        let elsewhere = elsewhere.cloned();
        let start = elsewhere.as_ref().unwrap_or(fitted);
        let causes = elsewhere
            .as_ref()
            .map_or(causes, |start| start.effects.clone());
        let all: Vec<_> = causes.into_iter().map(zeros).collect();
        let from = Some((&**start, start.x.as_slice()));
        let found = self.settled(&all, from)?;
        self.note(&found);
        self.begun.push((Arc::clone(&found), Arc::clone(fitted)));
        Some(found)
    }
}

/// A further slider, guesses of its numbers and the unknowns of the fit.
type Halved = (CandidateEffect, Vec<f64>, Vec<f64>);

/// Starts a further slider with half of the first one's force. The first keeps the other half and slips sooner, the further one later.
fn halved(base: &FittedModel, h: &CandidateEffect) -> Option<Halved> {
    let first = base
        .effects
        .iter()
        .position(|c| c.term == Term::Main && h.term > Term::Main && c.same_site(h))?;
    let [force, length, anchor] = base.parameter_index[first][..] else {
        return None;
    };
    let mut h = h.clone();
    let [_, stiffness, at] = &mut h.numbers[..] else {
        return None;
    };
    let Parametrisation::SlipLength { start, .. } = &mut stiffness.unknown else {
        return None;
    };
    let mut x = base.x.clone();
    *start = libm::exp(x[length]) * SLIPS[1];
    x[length] += libm::log(SLIPS[0]);
    x[force] *= 0.5;
    let guesses = vec![x[force], 0.0, x[anchor] - at.mean / at.sd];
    Some((h, guesses, x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::Catalogue;
    use crate::sought::tests::{of_the_axle, shipped_axle};

    /// A fit that stopped where it promised much begins anew from the deck if it would lead, and comes to where an undisturbed one ends.
    #[test]
    fn a_fit_that_is_stuck_begins_anew_where_its_promise_leads() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let (subject, none) = of_the_axle(&problem);
        let none = Arc::new(none);
        let catalogue = Catalogue::new(&subject, &none);
        let smooth = |at: usize| !catalogue.hypotheses[at].cause.has_rough_law();
        let promises = catalogue.scan(&none, &none.sizes);
        let promise = promises.iter().find(|promise| smooth(promise.at));
        let promise = promise.expect("something is promised");
        let weighed = catalogue.weigh(&none, promise.at, &none.sizes);
        let candidate = (
            &catalogue.hypotheses[promise.at],
            &weighed.expect("it promises something"),
        );
        let mut tried = Tried::new(&subject, Data::All);
        let found = tried.with(&none, candidate, f64::NEG_INFINITY);
        let found = found.expect("it can be fitted");
        let mut stuck = (*found).clone();
        stuck.posterior.gain += 2.0 * STUCK;
        let reached = found.ln_posterior();
        let again = tried.anew((&none, &stuck), candidate, reached - 1.0);
        let again = again.expect("a fit from the deck");
        assert!((again.ln_posterior() - reached).abs() < 0.1);
        // Others lead in spite of its promise, and one that came to its end promises nothing.
        assert!(
            tried
                .anew((&none, &stuck), candidate, reached + 1.0)
                .is_none()
        );
        assert!(
            tried
                .anew((&none, &found), candidate, reached - 1.0)
                .is_none()
        );
    }
}
