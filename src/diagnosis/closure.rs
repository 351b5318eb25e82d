//! Search in the linear model of one fit for the probable sets of effects. From a start set, effects are added, dropped and exchanged one at a
//! time. All sets found within Occam's window of the best set are kept: sets whose log posterior is at most a fixed amount below the largest.
//!
//! Source: Madigan and Raftery, Journal of the American Statistical Association 89 (1994) 1535.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::DVector;
use rayon::prelude::*;

use super::candidate_effect::{CandidateEffect, Term};
use super::cause::Cause;
use super::reduction::{Conditioned, EffectModel, Marginal, Reduction};
use super::settings::{MAX_EFFECTS, MAX_EXPANSIONS, OCCAM_WINDOW_NATS, RESOLVED_PROBABILITY};

/// Set of effects, given by the indices of the effects in an [`EffectModel`], in ascending order.
pub(super) type EffectSet = Vec<usize>;

/// Sets of effects, each with its log posterior odds against the model without effects: log Bayes factor plus log prior odds.
pub(super) type Pool = BTreeMap<EffectSet, f64>;

/// Effect that may be added to a set.
pub(super) struct Addition {
    /// Index of the effect in the [`EffectModel`].
    pub effect: usize,
    /// Log posterior odds of the enlarged set against the model without effects.
    pub score: f64,
    /// Posterior mean of the effect's parameters in the enlarged set, in units of their prior standard deviations.
    pub mean: DVector<f64>,
}

/// Evaluation of sets of effects in the linear model of one fit, at fixed variance components.
pub(super) struct Sets<'a> {
    model: &'a EffectModel,
    reduction: Reduction<'a>,
}

impl<'a> Sets<'a> {
    pub(super) const fn new(model: &'a EffectModel, marginal: &'a Marginal) -> Self {
        Self {
            model,
            reduction: model.reduction(marginal),
        }
    }

    /// Computes the posterior of the parameters of a set of effects in the linear model. Returns `None` if the information matrix is not positive
    /// definite.
    pub(super) fn conditioned(&self, set: &[usize]) -> Option<Conditioned> {
        let ranges = set.iter().map(|k| &self.model.ranges[*k]);
        self.reduction.conditioned(ranges)
    }

    /// Returns the log posterior odds of a set against the model without effects. Returns `None` if the estimate of a one-sided effect in the set
    /// is not positive.
    pub(super) fn score(&self, set: &[usize]) -> Option<f64> {
        let found = self.conditioned(set)?;
        self.has_right_signs(set, &found)
            .then(|| found.ln_bayes_factor + self.ln_prior(set))
    }

    fn has_right_signs(&self, set: &[usize], found: &Conditioned) -> bool {
        let mut at = 0;
        set.iter().all(|k| {
            let first = at;
            at += self.model.ranges[*k].len();
            !self.model.effects[*k].one_sided || at == first || found.mean[first] > 0.0
        })
    }

    /// Returns the log prior odds of a set, with the corrections of scanned laws.
    fn ln_prior(&self, set: &[usize]) -> f64 {
        let corrections: f64 = set.iter().map(|k| self.model.corrections[*k]).sum();
        corrections + self.ln_prior_odds(set)
    }

    fn ln_prior_odds(&self, set: &[usize]) -> f64 {
        let effects = &self.model.effects;
        let progressive = |k: &&usize| effects[**k].cause == Cause::ProgressiveStiffness;
        if set.iter().filter(progressive).count() < 2 {
            return set.iter().map(|k| effects[*k].ln_prior).sum();
        }
        let all: Vec<CandidateEffect> = set.iter().map(|k| effects[*k].clone()).collect();
        CandidateEffect::ln_prior_of(&all)
    }

    /// Returns true if an effect may be added to a set. A site may have only one form of a law. A further term of a law requires the main term of
    /// that law. An effect whose linearisation is poor is not combined with other effects that are new to the fit.
    fn may_join(&self, set: &[usize], effect: usize) -> bool {
        let new = &self.model.effects[effect];
        let mut there = set.iter().map(|k| &self.model.effects[*k]);
        let is_first_order = |k: &usize| self.is_leaf(*k);
        if self.is_leaf(effect) && set.iter().any(|k| *k >= self.model.own)
            || set.iter().any(is_first_order)
        {
            return false;
        }
        // An alternative function of a law in the fit is fitted as a challenger.
        let is_of_fit = |own: &CandidateEffect| own.is_alternative(new);
        if effect >= self.model.own && self.model.effects[..self.model.own].iter().any(is_of_fit) {
            return false;
        }
        match new.term {
            Term::Main => !there.any(|other| other.same_site(new) || is_rival(other, new)),
            term => {
                let mut main = false;
                for other in there.filter(|other| other.same_site(new)) {
                    main |= other.term == Term::Main;
                    if other.term == term || other.joint_with.is_some() {
                        return false;
                    }
                }
                main
            }
        }
    }

    /// Returns true if an effect may be dropped from a set. The main term of a law cannot be dropped while the set contains further terms of that
    /// law.
    pub(super) fn may_leave(&self, set: &[usize], effect: usize) -> bool {
        let own = &self.model.effects[effect];
        let mut others = set.iter().map(|k| &self.model.effects[*k]);
        !others.any(|other| other.term > own.term && other.same_site(own))
    }

    /// Returns true for an effect that is not in the fit and whose linearisation is poor. A set that contains such an effect is not enlarged.
    fn is_leaf(&self, effect: usize) -> bool {
        effect >= self.model.own && self.model.effects[effect].is_poorly_linearised()
    }

    /// Returns the sets within Occam's window that are reached from `start` by adding, dropping and exchanging single effects. If `with_pairs`
    /// is true, the best pairs of effects are further start sets.
    pub(super) fn closure(&self, start: &EffectSet, with_pairs: bool) -> Pool {
        let mut pool = Pool::new();
        if let Some(score) = self.score(start) {
            pool.insert(start.clone(), score);
        }
        // The empty set always serves as the reference.
        pool.entry(Vec::new()).or_insert(0.0);
        let mut done = BTreeSet::new();
        if with_pairs {
            for (set, score) in self.pairs() {
                pool.insert(set, score);
            }
        }
        for _ in 0..MAX_EXPANSIONS {
            let best = pool.values().copied().fold(f64::NEG_INFINITY, f64::max);
            let least = best + libm::log(RESOLVED_PROBABILITY);
            let open = pool
                .iter()
                .filter(|(set, score)| **score > least && !done.contains(*set));
            let Some((set, _)) = open.max_by(|a, b| a.1.total_cmp(b.1)) else {
                break;
            };
            let set = set.clone();
            done.insert(set.clone());
            for (set, score) in self.expanded(&set, best - OCCAM_WINDOW_NATS) {
                pool.insert(set, score);
            }
        }
        let best = pool.values().copied().fold(f64::NEG_INFINITY, f64::max);
        pool.retain(|_, score| *score > best - OCCAM_WINDOW_NATS);
        pool
    }

    /// Returns the sets that differ from `start` by one added, dropped or exchanged effect and are more probable.
    pub(super) fn neighbours(&self, start: &EffectSet) -> Pool {
        let Some(own) = self.score(start) else {
            return Pool::new();
        };
        let all = self.expanded(start, own).into_iter();
        all.filter(|(_, score)| *score > own).collect()
    }

    /// Returns the sets that differ from `set` by one added, dropped or exchanged effect, with their log posterior odds. Enlarged sets at or
    /// below `least` are left out.
    fn expanded(&self, set: &EffectSet, least: f64) -> Vec<(EffectSet, f64)> {
        let mut bases = vec![set.clone()];
        for effect in set {
            if self.may_leave(set, *effect) {
                bases.push(set.iter().copied().filter(|k| k != effect).collect());
            }
        }
        let of = |base: &EffectSet| {
            let mut out: Vec<(EffectSet, f64)> = Vec::new();
            if let Some(score) = self.score(base) {
                out.push((base.clone(), score));
            }
            for addition in self.additions(base) {
                let mut larger = base.clone();
                larger.push(addition.effect);
                larger.sort_unstable();
                if addition.score > least
                    && let Some(score) = self.score(&larger)
                {
                    out.push((larger, score));
                }
            }
            out
        };
        bases.par_iter().map(of).flatten().collect()
    }

    /// Returns the effects that may be added to a set, with the log posterior odds of the enlarged set.
    pub(super) fn additions(&self, base: &EffectSet) -> Vec<Addition> {
        let mut out = Vec::new();
        let Some(known) = self.conditioned(base) else {
            return out;
        };
        if base.len() >= MAX_EFFECTS {
            return out;
        }
        let ln_prior = self.ln_prior(base);
        for effect in 0..self.model.effects.len() {
            let range = &self.model.ranges[effect];
            if range.is_empty() || base.contains(&effect) || !self.may_join(base, effect) {
                continue;
            }
            let Some((gain, mean)) = self.reduction.beside(&known, range, effect) else {
                continue;
            };
            let new = &self.model.effects[effect];
            if new.one_sided && mean[0] <= 0.0 {
                continue;
            }
            let prior = if new.cause == Cause::ProgressiveStiffness {
                let mut larger = base.clone();
                larger.push(effect);
                self.ln_prior(&larger)
            } else {
                ln_prior + new.ln_prior + self.model.corrections[effect]
            };
            let score = known.ln_bayes_factor + gain + prior;
            out.push(Addition {
                effect,
                score,
                mean,
            });
        }
        out
    }

    /// Returns the best pairs of effects, each effect with a single column. Two correlated effects may explain the readings only together, so
    /// that neither is found alone.
    fn pairs(&self) -> Vec<(EffectSet, f64)> {
        let model = self.model;
        let single: Vec<usize> = (0..model.effects.len())
            .filter(|k| model.ranges[*k].len() == 1 && !self.is_leaf(*k))
            .filter(|k| model.effects[*k].term == Term::Main)
            .collect();
        let Some(M) = self.reduction.information() else {
            return Vec::new();
        };
        let g = self.reduction.gradient();
        let column = |k: usize| model.ranges[k].start;
        let of = |(n, &a): (usize, &usize)| {
            let (i, mut out) = (column(a), Vec::new());
            for &b in &single[n + 1..] {
                let j = column(b);
                let (p, q) = (1.0 + M[(i, i)], 1.0 + M[(j, j)]);
                let x = M[(i.max(j), i.min(j))];
                // Nearly uncorrelated effects need no joint test: each of them is also found alone.
                if x * x < 0.25 * p * q {
                    continue;
                }
                let det = p * q - x * x;
                let (u, v) = ((g[i] * q - g[j] * x) / det, (g[j] * p - g[i] * x) / det);
                let is_wrong = (model.effects[a].one_sided && u <= 0.0)
                    || (model.effects[b].one_sided && v <= 0.0);
                if is_wrong || model.effects[a].same_site(&model.effects[b]) {
                    continue;
                }
                let score = 0.5 * (u * g[i] + v * g[j]) - 0.5 * libm::log(det)
                    + model.effects[a].ln_prior
                    + model.effects[b].ln_prior;
                if score > -OCCAM_WINDOW_NATS {
                    out.push((vec![a, b], score));
                }
            }
            out
        };
        let mut found: Vec<(EffectSet, f64)> =
            single.par_iter().enumerate().map(of).flatten().collect();
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found.truncate(MAX_EXPANSIONS);
        found
    }

    /// Returns the contribution of each effect of a set to the prediction. A contribution consists of pairs of column index and coefficient.
    pub(super) fn contributions(&self, set: &[usize]) -> Option<Vec<Vec<(usize, f64)>>> {
        let found = self.conditioned(set)?;
        let mut at = 0;
        let of = |k: &usize| {
            let range = self.model.ranges[*k].clone();
            let own = range.map(|column| {
                at += 1;
                (column, found.mean[at - 1])
            });
            own.collect()
        };
        Some(set.iter().map(of).collect())
    }

    /// Returns the squared distance between the predictions of two sets, in units of noise. `a` and `b` hold the contributions of their effects.
    /// The effects are paired so that the sum of squared differences is smallest; an unpaired contribution counts in full.
    pub(super) fn distance(&self, a: &[Vec<(usize, f64)>], b: &[Vec<(usize, f64)>]) -> f64 {
        let product = |a: &[(usize, f64)], b: &[(usize, f64)]| -> f64 {
            let of = |(i, u): &(usize, f64)| -> f64 {
                // The columns of both sets are known: their contributions needed them.
                let M = self.reduction.information_column(*i);
                M.map_or(0.0, |M| b.iter().map(|(j, v)| u * v * M[*j]).sum())
            };
            a.iter().map(of).sum()
        };
        let [own, other] =
            [a, b].map(|set| -> Vec<f64> { set.iter().map(|part| product(part, part)).collect() });
        let n = a.len() + b.len();
        let cost = |i: usize, j: usize| match (i < a.len(), j < b.len()) {
            (true, true) => own[i] + other[j] - 2.0 * product(&a[i], &b[j]),
            (true, false) => own[i],
            (false, true) => other[j],
            (false, false) => 0.0,
        };
        let costs: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..n).map(|j| cost(i, j)).collect())
            .collect();
        least_assignment(&costs)
    }
}

/// Returns true if a cause and a force of unknown law have the same address. A set contains only one of them: the part of the force that the
/// cause does not explain is a further term of its law.
fn is_rival(a: &CandidateEffect, b: &CandidateEffect) -> bool {
    a.address == b.address && a.is_in_catalogue() != b.is_in_catalogue()
}

/// Returns the minimum cost of an assignment that gives each row a different column (Hungarian method with potentials).
fn least_assignment(costs: &[Vec<f64>]) -> f64 {
    let n = costs.len();
    let (mut u, mut v) = (vec![0.0; n + 1], vec![0.0; n + 1]);
    let mut matched = vec![0_usize; n + 1];
    for row in 1..=n {
        matched[0] = row;
        let (mut least, mut way) = (vec![f64::INFINITY; n + 1], vec![0_usize; n + 1]);
        let mut used = vec![false; n + 1];
        let mut column = 0;
        loop {
            used[column] = true;
            let (at, mut delta, mut next) = (matched[column], f64::INFINITY, 0);
            for j in 1..=n {
                if used[j] {
                    continue;
                }
                let reduced = costs[at - 1][j - 1] - u[at] - v[j];
                if reduced < least[j] {
                    (least[j], way[j]) = (reduced, column);
                }
                if least[j] < delta {
                    (delta, next) = (least[j], j);
                }
            }
            for j in 0..=n {
                if used[j] {
                    u[matched[j]] += delta;
                    v[j] -= delta;
                } else {
                    least[j] -= delta;
                }
            }
            column = next;
            if matched[column] == 0 {
                break;
            }
        }
        while column != 0 {
            matched[column] = matched[way[column]];
            column = way[column];
        }
    }
    (1..=n).map(|j| costs[matched[j] - 1][j - 1]).sum()
}

#[cfg(test)]
mod tests {
    use super::least_assignment;

    #[test]
    fn the_least_assignment_is_that_of_all_permutations() {
        let costs = vec![
            vec![4.0, 1.0, 3.0],
            vec![2.0, 0.0, 5.0],
            vec![3.0, 2.0, 2.0],
        ];
        let orders = [
            [0, 1, 2],
            [0, 2, 1],
            [1, 0, 2],
            [1, 2, 0],
            [2, 0, 1],
            [2, 1, 0],
        ];
        let sum = |order: &[usize; 3]| -> f64 { (0..3).map(|i| costs[i][order[i]]).sum() };
        let least = orders.iter().map(sum).fold(f64::INFINITY, f64::min);
        assert_eq!(least_assignment(&costs), least);
        assert_eq!(least_assignment(&[]), 0.0);
    }
}
