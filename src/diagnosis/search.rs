//! Which causes act: models are grown and pruned by their evidence, and every model that was looked at counts.

use std::sync::Arc;

use super::candidate_effect::{CandidateEffect, Term};
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::fit::{
    EarlyStopping, FitOutcome, FittedModel, fit_with_early_stopping, with_zero_guesses,
};
use super::rig_errors::{GaveWay, Promises, RigErrors};
use super::scan::{Catalogue, FORMS, Weighed, by_promise};
use super::select::closed;
use super::stand_in::{StandIns, left_by_friction, loosened};
use super::tried::{BETTER, Tried};
use super::visited::{Found, LINEAR, Visited, better, by_evidence, distinct, probabilities};
use admire_identify::tolerance::VarianceComponents;
use admire_study::settings::Selection;

/// What was promised is weighed with sizes of its own if that is no less than what would be refitted by so many nats,
const ASIDE: f64 = 300.0;
/// and of those so many places are refitted,
const REFITTED: usize = 3;
/// where they are within so many nats of the best; friction, whose first guess is rough, within so many more.
const WITHIN: (f64, f64) = (30.0, 600.0);
/// A promise of more than so many nats is far outside of the linear model: every place that promises this part of the best is refitted.
const FAR: (f64, f64) = (1000.0, 0.9);
/// A model with one cause more that would lose so many nats is not refitted; of a rough law, which the linear model says little of, one
/// that would lose so many.
const HOPELESS: (f64, f64) = (-2.0, -6.0);
/// Causes at most: a search that goes on further explains noise.
const MOST: usize = 12;
/// Further forms of a place whose first form ended so many nats behind are not fitted.
const BEHIND: f64 = 50.0;
/// A model has to be better by so many nats to be another place than the one a fit of the same causes came to.
const ELSEWHERE: f64 = 2.0;
/// Friction within so many nats of the best is fitted from other slip lengths as that is.
const NEAR: f64 = 10.0;
/// Some cause acts where the linear model promises so many nats of one.
const SURE: f64 = 10.0;
/// Causes that gain less than so many nats may only lead away from where the fit without them went astray.
const MODEST: f64 = 100.0;

/// Resumes a search from the models, without and with causes, that a search of some of the cases ended with. That one may have
/// avoided a fit that went astray here, or a first cause that hides the true one. `None` where its models are no better.
pub(super) fn resume(
    subject: &DiagnosisProblem<'_>,
    found: &Found,
    [none, best]: [&Arc<FittedModel>; 2],
    data: Data,
) -> Option<Found> {
    if subject.problem.selection == Selection::Closure {
        return None;
    }
    let better = |other: &Arc<FittedModel>, known: &Arc<FittedModel>| {
        let from = Some((&**other, other.x.as_slice()));
        let target = EarlyStopping::beyond(known);
        let again =
            fit_with_early_stopping(subject, &with_zero_guesses(other), from, None, data, target)?;
        let FitOutcome::New(again) = again else {
            return None;
        };
        let is_better = again.ln_posterior() > known.ln_posterior() + ELSEWHERE;
        is_better.then_some(again)
    };
    let none = better(none, &found.none);
    let best = better(best, &found.best);
    if none.is_none() && best.is_none() {
        return None;
    }
    let starts: Vec<Arc<FittedModel>> = best.into_iter().chain(none.clone()).collect();
    let none = none.unwrap_or_else(|| Arc::clone(&found.none));
    let mut search = Search::new(subject, none, data);
    search.tried.visited = found.models.iter().map(|(m, _)| m.clone()).collect();
    search.places = found.places;
    let mut ends = vec![Arc::clone(&found.best)];
    for start in starts {
        search.tried.note(&start);
        let start = search.pruned(start, 1);
        ends.push(search.climbed(start));
    }
    let best = ends.into_iter().max_by(by_evidence)?;
    Some(search.into_found(best))
}

/// One more cause for a model, as the linear model weighs it.
type Candidate = (CandidateEffect, Weighed);

/// A search on some of the cases.
pub(super) struct Search<'a, 'b> {
    /// The model without any cause.
    none: Arc<FittedModel>,
    tried: Tried<'a, 'b>,
    stand_ins: StandIns,
    /// Models, what was weighed beside each, and what that had to come near to.
    weighed: Vec<(Arc<FittedModel>, Arc<Vec<Candidate>>, f64)>,
    places: usize,
    /// Errors of the rig to which it gives way, what they promise, and those it gave way to.
    open: Vec<RigErrors>,
    promises: Promises,
    gave_way: Option<GaveWay>,
}

impl<'a, 'b> Search<'a, 'b> {
    /// From the model without any cause.
    pub(super) fn new(
        subject: &'a DiagnosisProblem<'b>,
        none: Arc<FittedModel>,
        data: Data,
    ) -> Self {
        let mut tried = Tried::new(subject, data);
        tried.note(&none);
        Self {
            none,
            tried,
            stand_ins: StandIns::default(),
            weighed: Vec::new(),
            places: 0,
            open: Vec::new(),
            promises: Promises::default(),
            gave_way: None,
        }
    }

    /// Ends where one of these errors of the rig promises far more than any cause does.
    pub(super) fn giving_way_to(mut self, open: &[RigErrors]) -> Self {
        self.open = open.to_vec();
        self
    }

    /// True where some cause acts for sure.
    pub(super) fn is_sure(&mut self) -> bool {
        let least = self.none.ln_posterior() + SURE;
        let none = Arc::clone(&self.none);
        let candidates = self.candidates(&none, f64::NEG_INFINITY);
        candidates
            .first()
            .is_some_and(|(_, weighed)| weighed.ln_posterior > least)
    }

    /// Searches to the end, from no cause.
    pub(super) fn ended(mut self) -> Found {
        if let Some(found) = closed(self.tried.subject, &self.none, self.tried.data) {
            return found;
        }
        let best = self.climbed(Arc::clone(&self.none));
        let best = self.held_against_none(best);
        self.into_found(best)
    }

    /// The same, or a better one beside a fit without any cause that begins where the one with them ended, where that is better than the
    /// one known: that one went astray.
    fn held_against_none(&mut self, best: Arc<FittedModel>) -> Arc<FittedModel> {
        let known = &self.none;
        let gained = best.ln_posterior() - known.ln_posterior();
        let is_open = self.gave_way.is_none() && !self.tried.subject.budget_exhausted();
        if best.effects.is_empty() || gained > MODEST || !is_open {
            return best;
        }
        let from = Some((&*best, best.x.as_slice()));
        let target = EarlyStopping::beyond(known);
        let again = self.tried.fitted(&[], from, None, target);
        let Some(FitOutcome::New(again)) = again else {
            return best;
        };
        if again.ln_posterior() < known.ln_posterior() + ELSEWHERE {
            return best;
        }
        self.none = again;
        let none = Arc::clone(&self.none);
        self.tried.note(&none);
        let other = self.climbed(none);
        if other.ln_posterior() > best.ln_posterior() {
            other
        } else {
            best
        }
    }

    /// Searches to the end from the causes that a search of some of the cases chose; from none, too, if what that would begin with is not
    /// among the causes this one comes to. `fits` are all that search fitted.
    pub(super) fn ended_from(mut self, chosen: &FittedModel, fits: &[Arc<FittedModel>]) -> Found {
        if let Some(found) = closed(self.tried.subject, &self.none, self.tried.data) {
            return found;
        }
        let none = Arc::clone(&self.none);
        let mut ends = Vec::new();
        let from = Some((chosen, chosen.x.as_slice()));
        let causes = with_zero_guesses(chosen);
        self.tried.elsewhere = fits.to_vec();
        let start = self.tried.settled(&causes, from);
        if let Some(start) = start.filter(|start| start.ln_posterior() > none.ln_posterior()) {
            self.tried.note(&start);
            let start = self.pruned(start, 0);
            ends.push(self.climbed(start));
        }
        let candidates = self.candidates(&none, f64::NEG_INFINITY);
        let is_held = |end: &Arc<FittedModel>| {
            candidates
                .first()
                .is_none_or(|(first, _)| end.effects.iter().any(|h| h.same_site(first)))
        };
        if self.gave_way.is_none() && !ends.iter().any(is_held) {
            ends.push(self.climbed(Arc::clone(&none)));
        }
        let best = ends.into_iter().max_by(by_evidence).unwrap_or(none);
        let best = self.held_against_none(best);
        self.into_found(best)
    }

    /// The best model that adding, dropping and exchanging causes leads to.
    fn climbed(&mut self, mut best: Arc<FittedModel>) -> Arc<FittedModel> {
        loop {
            while best.effects.len() < MOST && !self.tried.subject.budget_exhausted() {
                let candidates = self.candidates(&best, f64::NEG_INFINITY);
                let first = candidates.first().map(|(_, weighed)| weighed.ln_posterior);
                let first = first.map_or(best.ln_posterior(), |f| f.max(best.ln_posterior()));
                if let Some(next) = left_by_friction(&mut self.tried, &best, first) {
                    best = self.pruned(next, 1);
                    continue;
                }
                if self.gives_way(&best, first - best.ln_posterior()) {
                    return best;
                }
                let Some(next) = self.grown(&best) else {
                    break;
                };
                let next = self.restarted(&best, next);
                best = self.pruned(next, 1);
                best = self
                    .stand_ins
                    .unnamed(&mut self.tried, &best)
                    .unwrap_or(best);
            }
            best = self.exchanged(best);
            if let Some(next) = loosened(&mut self.tried, &best) {
                best = self.pruned(next, 1);
                continue;
            }
            let Some(next) = self.stand_ins.unnamed(&mut self.tried, &best) else {
                return best;
            };
            best = self.pruned(next, 1);
        }
    }

    /// True where errors of the rig promise far more than the best cause does, `promised`. A search with them has to come to what a force of an
    /// unknown law does, too.
    fn gives_way(&mut self, best: &Arc<FittedModel>, promised: f64) -> bool {
        let beside = (self.tried.subject, best);
        let foremost = self.promises.foremost(&self.open, beside, promised);
        let Some(mut gave_way) = foremost else {
            return false;
        };
        if self.tried.data == Data::All {
            let causes = best.effects.clone();
            let force = self.stand_ins.beside(&mut self.tried, best, causes);
            let worth = force.map_or(f64::NEG_INFINITY, |force| force.ln_posterior());
            gave_way.least = gave_way.least.max(worth);
        }
        self.gave_way = Some(gave_way);
        true
    }

    fn into_found(self, best: Arc<FittedModel>) -> Found {
        Found {
            none: self.none,
            best,
            models: probabilities(&self.tried.visited),
            places: self.places,
            cut_short: self.tried.subject.budget_exhausted(),
            gave_way: self.gave_way,
            promises: self.promises,
        }
    }

    /// Candidates for one more cause, weighed with their own sizes, best first. What promises far less than `least` is left out.
    fn candidates(&mut self, base: &Arc<FittedModel>, least: f64) -> Arc<Vec<Candidate>> {
        let known = self.weighed.iter();
        let mut known = known.filter(|(of, _, held)| Arc::ptr_eq(of, base) && *held <= least);
        if let Some((_, known, _)) = known.next() {
            return Arc::clone(known);
        }
        let catalogue = Catalogue::new(self.tried.subject, base);
        self.places = self.places.max(catalogue.hypotheses.len());
        let modest = base.sizes.at(base.sizes.capped_above_median(0.0));
        let mut union = catalogue.promised(base, [&base.sizes, &modest]);
        union.sort_by(by_promise);
        let start: VarianceComponents = base.sizes.at(base.sizes.capped_above_median(1.0));
        let mut out: Vec<Candidate> = Vec::new();
        let mut best = f64::NEG_INFINITY;
        for k in 0..union.len() {
            if self.tried.subject.progress().is_stopped() {
                break;
            }
            let (promise, at) = &union[k];
            let h = &catalogue.hypotheses[promise.at];
            let is_first = out.is_empty();
            let within = if h.memory.is_some() { WITHIN.1 } else { 0.0 };
            let is_far = promise.ln_posterior < best - within - ASIDE;
            if is_far || (!is_first && promise.ln_posterior < least - ASIDE) {
                continue;
            }
            let from = if is_first { &start } else { at };
            let Some(weighed) = catalogue.weigh(base, promise.at, from) else {
                continue;
            };
            if is_first {
                // The sizes beside the first one are near to those beside the others.
                let rest = &mut union[k + 1..];
                for promise in catalogue.scan(base, &weighed.sizes) {
                    let mut known = rest.iter_mut();
                    if let Some((known, at)) = known.find(|(known, _)| known.at == promise.at)
                        && known.ln_posterior < promise.ln_posterior
                    {
                        (*known, *at) = (promise, weighed.sizes.clone());
                    }
                }
                rest.sort_by(by_promise);
            }
            best = best.max(weighed.ln_posterior);
            out.push((h.clone(), weighed));
        }
        out.sort_by(|a, b| b.1.ln_posterior.total_cmp(&a.1.ln_posterior));
        for (h, weighed) in &out {
            let mut causes = base.effects.clone();
            causes.extend(h.split());
            self.tried.visited.push(Visited {
                causes,
                ln_posterior: weighed.ln_posterior,
                fitted: None,
            });
        }
        let out = Arc::new(out);
        let known = (Arc::clone(base), Arc::clone(&out), least);
        self.weighed.push(known);
        out
    }

    /// Refits of candidates that may be better than `least`: all that would lose no more than `lost`, a rough law no more than its
    /// second number.
    fn refitted(
        &mut self,
        base: &Arc<FittedModel>,
        candidates: &[&Candidate],
        (least, lost): (f64, (f64, f64)),
    ) -> Option<Arc<FittedModel>> {
        // With a further part of its law a cause may promise much that it cannot keep.
        let alone = candidates.iter().find(|(h, _)| h.joint_with.is_none());
        let best = alone.or(candidates.first())?.1.ln_posterior;
        // Of every place its most promising form first.
        let mut forms: [Vec<(&CandidateEffect, &Weighed)>; FORMS] = Default::default();
        for (h, weighed) in candidates {
            let within = if h.memory.is_some() {
                WITHIN.1
            } else {
                WITHIN.0
            };
            let same = |of: &&(&CandidateEffect, &Weighed)| of.0.same_term(h);
            let known = forms.iter().flatten().filter(same).count();
            let mut places: Vec<&CandidateEffect> = forms[0].iter().map(|(h, _)| *h).collect();
            places.push(h);
            let (most, hopeless) = if h.is_poorly_linearised() {
                (FORMS, lost.1)
            } else {
                (1, lost.0)
            };
            let promised = best - least;
            let is_as_good = promised > FAR.0 && weighed.ln_posterior - least > FAR.1 * promised;
            if weighed.ln_posterior < (best - within).max(least + hopeless)
                || (known == 0 && distinct(&places) > REFITTED && !is_as_good)
                || known >= most
            {
                continue;
            }
            forms[known].push((h, weighed));
        }
        let mut reached: Vec<(&CandidateEffect, f64)> = Vec::new();
        let mut winner: Option<Arc<FittedModel>> = None;
        let mut ends: Vec<(&CandidateEffect, &Weighed, Arc<FittedModel>)> = Vec::new();
        for (h, weighed) in forms.into_iter().flatten() {
            if self.tried.subject.progress().is_stopped() {
                break;
            }
            let leads = winner
                .as_ref()
                .map_or(least, |w| w.ln_posterior().max(least));
            // Of a further slider the linear model knows well what it promises; with a further part it promises too much.
            let least = match (h.term, &h.joint_with) {
                (Term::Main, None) => f64::NEG_INFINITY,
                (Term::Main, Some(_)) => leads,
                _ => leads - LINEAR,
            };
            if weighed.ln_posterior < least {
                continue;
            }
            let far =
                |(other, ln): &(&CandidateEffect, f64)| other.same_term(h) && *ln < leads - BEHIND;
            // What a slider of the winner would come to from another first guess is seen when that is fitted anew.
            let is_winner = |w: &Arc<FittedModel>| {
                w.is_converged() && w.effects.last().is_some_and(|l| l.same_site(h))
            };
            if reached.iter().any(far)
                || (h.memory.is_some() && winner.as_ref().is_some_and(is_winner))
            {
                continue;
            }
            let Some(found) = self.tried.with(base, (h, weighed), leads) else {
                continue;
            };
            reached.push((h, found.ln_posterior()));
            ends.push((h, weighed, Arc::clone(&found)));
            winner = Some(better(winner, found));
        }
        // One that is stuck begins anew only if its promise leads all others.
        for (h, weighed, found) in ends {
            let leads = winner
                .as_ref()
                .map_or(least, |w| w.ln_posterior().max(least));
            if let Some(again) = self.tried.anew((base, &found), (h, weighed), leads) {
                winner = Some(better(winner, again));
            }
        }
        winner
    }

    /// The best model with one more cause, if it is better.
    fn grown(&mut self, base: &Arc<FittedModel>) -> Option<Arc<FittedModel>> {
        let candidates = self.candidates(base, f64::NEG_INFINITY);
        let least = base.ln_posterior();
        let all: Vec<&Candidate> = candidates.iter().collect();
        let winner = self.refitted(base, &all, (least, HOPELESS))?;
        let winner = self.beside_winner(base, &candidates, winner);
        (winner.ln_posterior() > least + BETTER).then_some(winner)
    }

    /// The best of a winner and what came near it beside `base`, friction fitted anew from other slip lengths: with the winner's alone
    /// its place would look certain.
    fn restarted(&mut self, base: &Arc<FittedModel>, winner: Arc<FittedModel>) -> Arc<FittedModel> {
        let least = winner.ln_posterior() - NEAR;
        let rivals = self.tried.beside(base, &winner, least);
        let mut best = self.tried.restarted(winner);
        for rival in rivals {
            let rival = self.tried.restarted(rival);
            if rival.ln_posterior() > best.ln_posterior() {
                best = rival;
            }
        }
        best
    }

    /// Fits a law without memory at the next places that promise it, from what the winner found, unless a fit there has come to its end:
    /// the guesses of the linear model may lead astray, and the winner's place would look certain.
    fn beside_winner(
        &mut self,
        base: &FittedModel,
        candidates: &[Candidate],
        winner: Arc<FittedModel>,
    ) -> Arc<FittedModel> {
        let (Some(own), Some(places)) = (winner.effects.last(), winner.parameter_index.last())
        else {
            return winner;
        };
        if !own.is_poorly_linearised() || own.memory.is_some() {
            return winner;
        }
        let guesses: Vec<f64> = places.iter().map(|at| winner.x[*at]).collect();
        let mut tried: Vec<&CandidateEffect> = Vec::new();
        let mut best = Arc::clone(&winner);
        for (h, _) in candidates {
            let is_alike = h.cause == own.cause && h.numbers.len() == own.numbers.len();
            let is_tried = tried.iter().chain([&own]).any(|other| other.same_site(h));
            if !is_alike || tried.len() == REFITTED || is_tried {
                continue;
            }
            tried.push(h);
            let mut all = with_zero_guesses(base);
            all.push((h.clone(), guesses.clone()));
            let causes: Vec<CandidateEffect> = all.iter().map(|(h, _)| h.clone()).collect();
            if self.tried.known(&causes).is_some() {
                continue;
            }
            let from = Some((&*winner, winner.x.as_slice()));
            let target = EarlyStopping {
                lead: winner.ln_posterior().max(base.ln_posterior())
                    - base.ln_prior()
                    - h.ln_prior_given(&base.effects),
                ..EarlyStopping::NONE
            };
            let found = self.tried.fitted(&all, from, None, target);
            if let Some(FitOutcome::New(found)) = found
                && !found.has_wrong_sign(all.len() - 1)
            {
                self.tried.note(&found);
                if found.ln_posterior() > best.ln_posterior() {
                    best = found;
                }
            }
        }
        best
    }

    /// Drops what the other causes of a model make needless; the last ones in stay.
    fn pruned(&mut self, mut current: Arc<FittedModel>, stay: usize) -> Arc<FittedModel> {
        let mut at = 0;
        while at + stay < current.effects.len() {
            if current.effects[at].is_refined(&current.effects) {
                at += 1;
                continue;
            }
            match self.tried.without(&current, at) {
                Some(found) if found.ln_posterior() > current.ln_posterior() => {
                    current = found;
                    at = 0;
                }
                _ => at += 1,
            }
        }
        current
    }

    /// Holds each cause against what else could stand in its place; what would count beside it is refitted.
    fn exchanged(&mut self, mut current: Arc<FittedModel>) -> Arc<FittedModel> {
        let mut at = 0;
        while at < current.effects.len() && !self.tried.subject.budget_exhausted() {
            let base = if current.effects[at].is_refined(&current.effects) {
                self.tried.without_all_parts(&current, at, &self.none)
            } else if current.effects.len() == 1 {
                Some(Arc::clone(&self.none))
            } else {
                self.tried.without_refitted(&current, at)
            };
            let Some(base) = base else {
                at += 1;
                continue;
            };
            let least = current.ln_posterior();
            let candidates = self.candidates(&base, least);
            let own = &current.effects[at];
            let is_refined = own.is_refined(&current.effects);
            let is_other =
                |(h, _): &&Candidate| !(h.same_form(own) || is_refined && h.same_site(own));
            let others: Vec<&Candidate> = candidates.iter().filter(is_other).collect();
            // Where a fit gains on what the linear model promised of it, that of a rival may gain as much.
            let of_own = candidates.iter().filter(|(h, _)| h.same_site(own));
            let of_own = of_own.map(|(_, weighed)| weighed.ln_posterior - least);
            let lost = of_own.reduce(f64::max).unwrap_or(0.0).min(0.0) - LINEAR;
            match self.refitted(&base, &others, (least, (lost, lost))) {
                Some(found) if found.ln_posterior() > least + BETTER => {
                    let found = self.restarted(&base, found);
                    current = self.pruned(found, 1);
                    at = 0;
                }
                _ => {
                    let own = &current.effects[at];
                    // Further sliders only say how friction gives way.
                    let found = if is_refined && own.memory.is_none() {
                        self.in_two(&base, own)
                    } else {
                        None
                    };
                    match found.filter(|found| found.ln_posterior() > least + BETTER) {
                        Some(found) => {
                            current = self.pruned(found, 2);
                            at = 0;
                        }
                        None => at += 1,
                    }
                }
            }
        }
        current
    }

    /// The best model with two causes more, neither of them at this place: a law of several parts may stand in for both.
    fn in_two(
        &mut self,
        base: &Arc<FittedModel>,
        place: &CandidateEffect,
    ) -> Option<Arc<FittedModel>> {
        let mut found = Arc::clone(base);
        for _ in 0..2 {
            let candidates = self.candidates(&found, f64::NEG_INFINITY);
            let others = candidates.iter().filter(|(h, _)| !h.same_site(place));
            let others: Vec<&Candidate> = others.collect();
            let least = found.ln_posterior();
            found = self.refitted(&found, &others, (least, HOPELESS))?;
        }
        Some(found)
    }
}

#[cfg(test)]
mod tests;
