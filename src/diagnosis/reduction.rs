//! Linear model of a fit, reduced to the parameters of its effects. All other unknowns (stiffnesses, tolerances and nuisance unknowns of the
//! measurement) are marginalised once. The evidence of any set of effects then costs one small Cholesky factorisation.
//!
//! Let `A` be the whitened Jacobian of the marginalised unknowns, `T` their prior covariance, and `z` the whitened residual (reading minus
//! prediction). Let `E` be the whitened columns of the effects, per prior standard deviation. With `P = (1 + A T A')^-1`, the information matrix
//! is `M = E'PE` and the gradient is `g = E'P z`. Let `Z0` be the evidence without effects. A set `S` of effects has the log evidence
//! `ln Z(S) = ln Z0 + g_S' (1 + M_SS)^-1 g_S / 2 - ln det(1 + M_SS) / 2`.
//!
//! Sources: George and McCulloch, Statistica Sinica 7 (1997) 339; Rasmussen and Williams, Gaussian Processes, section 2.7.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::candidate_effect::{CandidateEffect, EffectParameter, Parametrisation, Sensitivity};
use super::causes::{self, dry_friction};
use super::diagnosis_problem::DiagnosisProblem;
use super::fit::FittedModel;
use super::operating_points::OperatingPoints;
use super::site::Sites;
use super::site_law::Scanned;
use admire_identify::tolerance::{
    EffectProducts, LinearModel, RowsByVarianceClass, VarianceComponents, transposed,
};

/// Effects linearised at a fit, with the linear model of all other unknowns.
pub(super) struct EffectModel {
    /// Fit at which the effects are linearised.
    pub fitted: Arc<FittedModel>,
    /// Effects in the fit, followed by all other candidates.
    pub effects: Vec<CandidateEffect>,
    /// Number of effects in the fit. They come first in `effects`.
    pub own: usize,
    /// Range of column indices of each effect.
    pub ranges: Vec<Range<usize>>,
    /// Result of the scan of each effect whose law is scanned at its site.
    pub scans: Vec<Option<Scanned>>,
    /// Correction that is added to the log Bayes factor of each effect. The linear model represents a law with memory by a force of fixed
    /// pattern; the correction turns the log Bayes factor of this force into that of the law. It is zero for all other effects.
    pub corrections: Vec<f64>,
    /// Products of the columns of the effects. A column is the change of the prediction per prior standard deviation of a parameter.
    products: Option<EffectProducts>,
    /// Indices of the fit's unknowns in the order of `base`. Parameters of effects are left out.
    kept: Vec<usize>,
    base: LinearModel,
}

/// [`EffectModel`] at fixed variance components, with all unknowns marginalised except the parameters of effects.
pub(super) struct Reduction<'m> {
    model: &'m EffectModel,
    marginal: &'m Marginal,
}

/// Marginalisation of the unknowns of an [`EffectModel`] at fixed variance components.
pub(super) struct Marginal {
    /// Log evidence of the model without effects.
    pub ln_z: f64,
    /// Gradient `g` of the log evidence with respect to the effect parameters, defined in the module documentation.
    pub gradient: DVector<f64>,
    /// Logarithms of the standard deviations.
    ln: Vec<f64>,
    /// Change of the other unknowns from the fit to the optimum of the linear model without effects.
    step: DVector<f64>,
    /// Products of the Jacobian with the columns of the effects, weighted by the reciprocal variances of the rows.
    cross: DMatrix<f64>,
    /// Decrease of `step` per unit of each effect parameter, one column per parameter.
    absorbed: DMatrix<f64>,
    /// For each effect, its diagonal block of the information matrix.
    own: Vec<DMatrix<f64>>,
    /// Columns of the information matrix `M` that were computed so far.
    columns: Vec<OnceLock<DVector<f64>>>,
}

/// Posterior of the parameters of one set of effects in a [`Reduction`].
pub(super) struct Conditioned {
    /// Column indices of the effects in the set.
    pub columns: Vec<usize>,
    /// Cholesky factor of `1 + M_SS`, where `M_SS` is the block of the information matrix for this set.
    factor: Cholesky<f64, Dyn>,
    /// Posterior mean of the parameters of the set, in units of their prior standard deviations.
    pub mean: DVector<f64>,
    /// Log Bayes factor of the set against the model without effects. Prior odds are not included.
    pub ln_bayes_factor: f64,
}

impl EffectModel {
    /// Linearises the effects in a fit and all other candidates. `further` holds candidates in addition to the catalogue of causes, and `sites`
    /// the sites of the fit.
    pub(super) fn new(
        subject: &DiagnosisProblem<'_>,
        fitted: &Arc<FittedModel>,
        sites: &Sites,
        further: Vec<CandidateEffect>,
    ) -> Self {
        let survey = OperatingPoints::new(subject, fitted);
        let mut effects = fitted.effects.clone();
        let own = effects.len();
        let mut scans: Vec<Option<Scanned>> = vec![None; own];
        effects.extend(causes::candidates(&survey, fitted));
        effects.extend(further);
        scans.resize(effects.len(), None);
        for (effect, scan) in dry_friction::scanned(&survey, sites) {
            effects.push(effect);
            scans.push(Some(scan));
        }
        let seen: Vec<&EffectParameter> = effects[own..].iter().flat_map(with_column).collect();
        let mut responses = survey.responses(&seen);
        let fresh = fitted.whitening.apply(&responses.columns(seen.len()));
        let whole = fitted.whitened_jacobian();
        let mut residual = fitted.whitened_residual();
        let mut columns: Vec<DVector<f64>> = Vec::new();
        let mut ranges = Vec::new();
        let mut is_kept = vec![true; fitted.x.len()];
        let mut priors = fitted.priors.clone();
        let mut next = 0;
        for (k, effect) in effects.iter().enumerate() {
            let from = columns.len();
            for (n, number) in effect.numbers.iter().enumerate() {
                if let Parametrisation::Member(member) = number.unknown {
                    let at = first_member(fitted) + member;
                    columns.push(whole.column(at) * number.sd);
                    if k < own {
                        priors[at].sd = 0.0;
                    }
                } else if k < own {
                    let at = fitted.parameter_index[k][n];
                    is_kept[at] = false;
                    if effect.is_held(n) {
                        continue;
                    }
                    let (column, off) = natural(number, fitted.x[at], priors[at].sd);
                    columns.push(whole.column(at) * column);
                    residual.axpy(off, &whole.column(at), 1.0);
                } else if number.column != Sensitivity::None {
                    columns.push(fresh.column(next).into_owned());
                    next += 1;
                }
            }
            ranges.push(from..columns.len());
        }
        let kept: Vec<usize> = (0..is_kept.len()).filter(|k| is_kept[*k]).collect();
        let jacobian = whole.select_columns(&kept);
        let whitening = &fitted.whitening;
        let by_class = RowsByVarianceClass::new(whitening, &jacobian);
        let base = LinearModel::new(
            whitening,
            &by_class,
            &residual,
            kept.iter().map(|k| priors[*k]).collect(),
            DVector::from_iterator(kept.len(), kept.iter().map(|k| fitted.x[*k])),
        );
        let columns = if columns.is_empty() {
            DMatrix::zeros(residual.len(), 0)
        } else {
            DMatrix::from_columns(&columns)
        };
        let columns = RowsByVarianceClass::new(whitening, &columns);
        let products = EffectProducts::new(whitening, &by_class, &residual, columns);
        let correction = |scan: &Option<Scanned>| scan.as_ref().map_or(0.0, |s| s.correction);
        Self {
            fitted: Arc::clone(fitted),
            corrections: scans.iter().map(correction).collect(),
            effects,
            own,
            ranges,
            scans,
            products: Some(products),
            kept,
            base,
        }
    }

    /// Frees the memory of the products. Columns of the information matrix that were computed before remain known; no others can be computed.
    pub(super) fn forget_products(&mut self) {
        self.products = None;
    }

    /// Marginalises all unknowns except the parameters of effects, at the variance components `sizes`. Returns `None` if the linear model has no
    /// finite solution.
    pub(super) fn marginalised(&self, sizes: &VarianceComponents) -> Option<Marginal> {
        let products = self.products.as_ref()?;
        let posterior = self.base.posterior(sizes)?;
        let cross = products.cross(&sizes.ln);
        let absorbed = transposed(&posterior.covariance, &cross);
        let own = self.ranges.iter().map(|range| {
            let [cross, absorbed] =
                [&cross, &absorbed].map(|of| of.columns(range.start, range.len()));
            products.gram_block(&sizes.ln, range.clone()) - cross.tr_mul(&absorbed)
        });
        Some(Marginal {
            ln_z: posterior.ln_z,
            gradient: products.gradient(&sizes.ln) - cross.tr_mul(&posterior.step),
            own: own.collect(),
            columns: vec![OnceLock::new(); cross.ncols()],
            ln: sizes.ln.clone(),
            step: posterior.step,
            cross,
            absorbed,
        })
    }

    /// Corrects the log Bayes factors of the laws with memory in the fit, so that the score of the fitted set is the evidence of the fit. Only the
    /// force of such a law has a column; its other parameters keep their values. `marginal` is at the variance components of the fit.
    pub(super) fn correct_held_laws(&mut self, marginal: &Marginal) {
        let held = |k: &usize| self.effects[*k].memory.is_some();
        let held: Vec<usize> = (0..self.own).filter(held).collect();
        let own = self.ranges[..self.own].iter();
        let conditioned = || self.reduction(marginal).conditioned(own);
        let Some(set) = (!held.is_empty()).then(conditioned).flatten() else {
            return;
        };
        let left = self.fitted.posterior.ln_z - marginal.ln_z - set.ln_bayes_factor;
        for k in &held {
            self.corrections[*k] = left / held.len() as f64;
        }
    }

    /// Combines this model with one of its marginals.
    pub(super) const fn reduction<'m>(&'m self, marginal: &'m Marginal) -> Reduction<'m> {
        Reduction {
            model: self,
            marginal,
        }
    }

    /// Returns start values of the fit's unknowns for a new fit with a set of effects: the optimum of the linear model with this set. Changes of
    /// unknowns without a tolerance group, such as logarithms of stiffnesses, are limited to `reach`. Parameters of the fit's effects keep their
    /// values if the effect is not in the set, or if the fit uses the logarithm of the parameter.
    pub(super) fn start(&self, marginal: &Marginal, set: &Conditioned, reach: f64) -> Vec<f64> {
        let mut step = marginal.step.clone();
        for (column, mean) in set.columns.iter().zip(set.mean.iter()) {
            step.axpy(-mean, &marginal.absorbed.column(*column), 1.0);
        }
        let mut x = self.fitted.x.clone();
        for (at, step) in self.kept.iter().zip(step.iter()) {
            let is_member = self.fitted.priors[*at].group.is_some();
            x[*at] += if is_member {
                *step
            } else {
                step.clamp(-reach, reach)
            };
        }
        let value = |column: usize| {
            let at = set.columns.iter().position(|own| *own == column)?;
            Some(set.mean[at])
        };
        for (k, range) in self.ranges[..self.own].iter().enumerate() {
            for (n, number) in self.effects[k].numbers.iter().enumerate() {
                let column = range.clone().nth(n);
                let Some(mean) = column.and_then(&value) else {
                    continue;
                };
                match number.unknown {
                    Parametrisation::Member(member) => {
                        x[first_member(&self.fitted) + member] += mean * number.sd;
                    }
                    Parametrisation::Compliance(_)
                    | Parametrisation::Rate { .. }
                    | Parametrisation::SlipLength { .. } => {}
                    _ => {
                        let at = self.fitted.parameter_index[k][n];
                        x[at] = mean * self.fitted.priors[at].sd;
                    }
                }
            }
        }
        x
    }

    /// Returns first guesses of the parameters of an effect that the fit does not contain yet, in units of their prior standard deviations.
    pub(super) fn guesses(
        &self,
        marginal: &Marginal,
        set: &Conditioned,
        effect: usize,
    ) -> Vec<f64> {
        let mut column = self.ranges[effect].start;
        let mut step = marginal.step.clone();
        for (column, mean) in set.columns.iter().zip(set.mean.iter()) {
            step.axpy(-mean, &marginal.absorbed.column(*column), 1.0);
        }
        let numbers = self.effects[effect].numbers.iter();
        numbers
            .map(|number| {
                let is_member = matches!(number.unknown, Parametrisation::Member(_));
                if !is_member && number.column == Sensitivity::None {
                    return 0.0;
                }
                let at = set.columns.iter().position(|own| *own == column);
                let own = at.map_or(0.0, |at| set.mean[at]);
                column += 1;
                match number.unknown {
                    Parametrisation::Member(member) => {
                        let at = first_member(&self.fitted) + member;
                        let kept = self.kept.iter().position(|kept| *kept == at);
                        let rest = self.fitted.x[at] + kept.map_or(0.0, |kept| step[kept]);
                        own + rest / number.sd
                    }
                    _ => own,
                }
            })
            .collect()
    }
}

impl Reduction<'_> {
    /// Returns the log evidence of the model without effects.
    #[cfg(test)]
    pub(super) const fn ln_z(&self) -> f64 {
        self.marginal.ln_z
    }

    /// Returns the gradient `g` of the log evidence with respect to the effect parameters.
    pub(super) const fn gradient(&self) -> &DVector<f64> {
        &self.marginal.gradient
    }

    /// Returns column `k` of the information matrix; `None` if it was not computed before the products were freed.
    pub(super) fn information_column(&self, k: usize) -> Option<&DVector<f64>> {
        let Marginal {
            columns,
            cross,
            absorbed,
            ln,
            ..
        } = self.marginal;
        if let Some(products) = &self.model.products {
            let new = || products.gram_column(ln, k) - absorbed.tr_mul(&cross.column(k));
            return Some(columns[k].get_or_init(new));
        }
        columns[k].get()
    }

    /// Returns the lower triangle of the information matrix; `None` if the products were freed.
    pub(super) fn information(&self) -> Option<DMatrix<f64>> {
        let Marginal {
            cross,
            absorbed,
            ln,
            ..
        } = self.marginal;
        let products = self.model.products.as_ref()?;
        Some(products.gram(ln) - transposed(cross, absorbed))
    }

    /// Returns the posterior of the effects with these column ranges. Returns `None` if `1 + M` of these columns is not positive definite.
    pub(super) fn conditioned<'r>(
        &self,
        ranges: impl Iterator<Item = &'r Range<usize>>,
    ) -> Option<Conditioned> {
        let columns: Vec<usize> = ranges.flat_map(Range::clone).collect();
        let Q = self.block(&columns, &columns)? + DMatrix::identity(columns.len(), columns.len());
        let factor = Cholesky::new(Q)?;
        let g = self.marginal.gradient.select_rows(&columns);
        let mean = factor.solve(&g);
        let ln_bayes_factor = 0.5 * g.dot(&mean) - half_ln_det(&factor);
        Some(Conditioned {
            columns,
            factor,
            mean,
            ln_bayes_factor,
        })
    }

    /// Returns the log Bayes factor for adding an effect, with its columns in `range`, to a set, and the posterior mean of its parameters in the
    /// enlarged set.
    pub(super) fn beside(
        &self,
        set: &Conditioned,
        range: &Range<usize>,
        effect: usize,
    ) -> Option<(f64, DVector<f64>)> {
        let own: Vec<usize> = range.clone().collect();
        let mut Q = &self.marginal.own[effect] + DMatrix::identity(own.len(), own.len());
        let mut g = self.marginal.gradient.select_rows(&own);
        if !set.columns.is_empty() {
            // Only known columns of the set are read, so the columns of the effect need not be computed.
            let cross = self.block(&own, &set.columns)?.transpose();
            Q -= cross.tr_mul(&set.factor.solve(&cross));
            g -= cross.tr_mul(&set.mean);
        }
        let factor = Cholesky::new(Q)?;
        let mean = factor.solve(&g);
        Some((0.5 * g.dot(&mean) - half_ln_det(&factor), mean))
    }

    /// Returns the information about each parameter of each effect, in units of its prior, with the effects of the fit marginalised.
    pub(super) fn information_beside_the_fit(&self) -> Vec<Vec<f64>> {
        let EffectModel { ranges, own, .. } = self.model;
        let Some(fit) = self.conditioned(ranges[..*own].iter()) else {
            return vec![Vec::new(); ranges.len()];
        };
        let of = |(range, block): (&Range<usize>, &DMatrix<f64>)| {
            let mut information = block.diagonal();
            let rows: Vec<usize> = range.clone().collect();
            if let Some(cross) = self.block(&rows, &fit.columns) {
                let cross = cross.transpose();
                information -= cross.tr_mul(&fit.factor.solve(&cross)).diagonal();
            }
            information.iter().copied().collect()
        };
        ranges.iter().zip(&self.marginal.own).map(of).collect()
    }

    /// Returns a block of the information matrix; `None` if a column is not known.
    fn block(&self, rows: &[usize], columns: &[usize]) -> Option<DMatrix<f64>> {
        let mut out = DMatrix::zeros(rows.len(), columns.len());
        for (j, k) in columns.iter().enumerate() {
            let column = self.information_column(*k)?;
            for (i, row) in rows.iter().enumerate() {
                out[(i, j)] = column[*row];
            }
        }
        Some(out)
    }
}

/// Returns half the log determinant of a factorised matrix.
fn half_ln_det(factor: &Cholesky<f64, Dyn>) -> f64 {
    let diagonal = factor.l_dirty().diagonal();
    diagonal.iter().map(|value| libm::log(*value)).sum()
}

/// Iterates over the parameters of a candidate that have a first-order effect. Random effects of tolerance groups are left out, because the
/// Jacobian of the fit already contains their columns.
fn with_column(effect: &CandidateEffect) -> impl Iterator<Item = &EffectParameter> {
    effect.numbers.iter().filter(|number| {
        number.column != Sensitivity::None && !matches!(number.unknown, Parametrisation::Member(_))
    })
}

/// Returns two numbers for a fitted parameter. The first is the factor that scales its Jacobian column to one prior standard deviation. The
/// second is the difference between its fitted value and its value without the effect. Both are linear in a compliance itself, not in the
/// logarithm of the stiffness that represents the compliance in the fit.
fn natural(number: &EffectParameter, x: f64, sd: f64) -> (f64, f64) {
    match number.unknown {
        // With stiffness exp(x) and compliance c = exp(-x): dx = -dc / c, and absence is c = 0.
        Parametrisation::Compliance(_) => (-number.sd * libm::exp(x), -1.0),
        _ => (sd, x - number.absent(x)),
    }
}

/// Returns the index of the first random effect among the unknowns of a fit.
pub(super) fn first_member(fitted: &FittedModel) -> usize {
    let members = fitted.priors.iter();
    members
        .clone()
        .position(|prior| prior.group.is_some())
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base_fit::tests::{axle_problem, shipped_axle};
    use crate::closure::Sets;
    use crate::diagnosis_problem::Data;
    use crate::fit::fit;
    use crate::remainder::sites_of;
    use crate::settings::OCCAM_WINDOW_NATS;

    /// Fits sets of effects. The evidence of each fit must equal the evidence of the same set in the linear model reduced at that fit.
    #[test]
    fn the_score_of_a_fitted_set_is_the_evidence_of_its_fit() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let (subject, none) = axle_problem(&problem);
        let none = Arc::new(none);
        let sites = sites_of(&subject, &none);
        let model = EffectModel::new(&subject, &none, &sites, Vec::new());
        // Only effects whose prior is the same in a fit and in the linear model are compared: neither compliances nor slip lengths. Of a law with memory
        // the linear model has the force alone.
        let is_same = |k: &usize| {
            let effect = &model.effects[*k];
            effect.memory.is_none()
                && effect.numbers.iter().all(|number| {
                    !matches!(
                        number.unknown,
                        Parametrisation::Compliance(_)
                            | Parametrisation::Rate { .. }
                            | Parametrisation::SlipLength { .. }
                    )
                })
        };
        let usable: Vec<usize> = (0..model.effects.len()).filter(is_same).collect();
        let picked: Vec<usize> = usable.iter().copied().step_by(usable.len() / 6).collect();
        let mut compared = 0;
        for set in picked.chunks(2) {
            let chosen: Vec<(CandidateEffect, Vec<f64>)> = set
                .iter()
                .map(|k| {
                    let effect = model.effects[*k].clone();
                    let guesses = vec![0.1; effect.numbers.len()];
                    (effect, guesses)
                })
                .collect();
            let from = Some((&*none, none.x.as_slice()));
            let Some(fitted) = fit(&subject, &chosen, from, Data::All) else {
                continue;
            };
            let fitted = Arc::new(fitted);
            let sites = sites_of(&subject, &fitted);
            let there = EffectModel::new(&subject, &fitted, &sites, Vec::new());
            let marginal = there.marginalised(&fitted.sizes).expect("a finite model");
            let reduction = there.reduction(&marginal);
            let own: Vec<usize> = (0..there.own).collect();
            let sets = Sets::new(&there, &marginal);
            let score = sets.conditioned(&own).expect("positive").ln_bayes_factor;
            let reached = fitted.posterior.ln_z;
            assert!(
                (reduction.ln_z() + score - reached).abs() < 1e-7,
                "{}: {} and {reached}",
                chosen
                    .iter()
                    .map(|(h, _)| h.to_string())
                    .collect::<Vec<_>>()
                    .join(", "),
                reduction.ln_z() + score
            );
            compared += 1;
        }
        assert!(compared >= 2, "{compared}");
    }

    /// Checks that the closure contains every pair of effects within Occam's window. The test uses a part of the catalogue.
    #[test]
    fn the_closure_holds_all_pairs_within_the_window() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let (subject, none) = axle_problem(&problem);
        let none = Arc::new(none);
        let sites = sites_of(&subject, &none);
        let mut model = EffectModel::new(&subject, &none, &sites, Vec::new());
        let keep: Vec<usize> = (0..model.effects.len())
            .filter(|k| !model.effects[*k].is_poorly_linearised())
            .step_by(5)
            .collect();
        model.effects = keep.iter().map(|k| model.effects[*k].clone()).collect();
        model.ranges = keep.iter().map(|k| model.ranges[*k].clone()).collect();
        model.corrections = vec![0.0; keep.len()];
        let marginal = model.marginalised(&none.sizes).expect("a finite model");
        let sets = Sets::new(&model, &marginal);
        let pool = sets.closure(&Vec::new(), true);
        let best = pool.values().copied().fold(f64::NEG_INFINITY, f64::max);
        let count = model.effects.len();
        let mut held = 0;
        for a in 0..count {
            for b in a + 1..count {
                if model.effects[a].same_site(&model.effects[b]) {
                    continue;
                }
                let set = vec![a, b];
                let Some(score) = sets.score(&set) else {
                    continue;
                };
                if score > best - OCCAM_WINDOW_NATS + 1e-9 {
                    let known = pool.get(&set);
                    assert!(
                        known.is_some_and(|known| (known - score).abs() < 1e-9),
                        "{} and {}: {score}, {known:?}",
                        model.effects[a],
                        model.effects[b]
                    );
                    held += 1;
                }
            }
        }
        println!("{held} pairs of {count} effects, {} sets", pool.len());
    }
}
