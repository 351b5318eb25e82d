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
use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::candidate_effect::{CandidateEffect, EffectParameter, Parametrisation, Sensitivity};
use super::causes;
use super::diagnosis_problem::DiagnosisProblem;
use super::fit::FittedModel;
use super::operating_points::OperatingPoints;
use admire_identify::tolerance::{
    LinearModel, RowsByVarianceClass, VarianceComponents, transposed,
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
    /// Change of the prediction per prior standard deviation of each effect parameter, one column per parameter. Rows are decorrelated, but not
    /// scaled to unit variance.
    columns: DMatrix<f64>,
    /// Indices of the fit's unknowns in the order of `base`. Parameters of effects are left out.
    kept: Vec<usize>,
    base: LinearModel,
    /// Jacobian of the unknowns in `kept`, in decorrelated rows that are not scaled to unit variance.
    jacobian: DMatrix<f64>,
    /// Residual (reading minus prediction) without the effects of the fit, in decorrelated rows that are not scaled to unit variance.
    residual: DVector<f64>,
}

/// [`EffectModel`] at fixed variance components, with all unknowns marginalised except the parameters of effects.
pub(super) struct Reduction {
    /// Log evidence of the model without effects.
    pub ln_z: f64,
    /// Information matrix `M` of the effect parameters, defined in the module documentation.
    pub information: DMatrix<f64>,
    /// Gradient `g` of the log evidence with respect to the effect parameters, defined in the module documentation.
    pub gradient: DVector<f64>,
    /// Change of the other unknowns from the fit to the optimum of the linear model without effects.
    step: DVector<f64>,
    /// Decrease of `step` per unit of each effect parameter, one column per parameter.
    absorbed: DMatrix<f64>,
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
    /// Linearises the effects in a fit and all other candidates. `further` holds candidates in addition to the catalogue of causes.
    pub(super) fn new(
        subject: &DiagnosisProblem<'_>,
        fitted: &Arc<FittedModel>,
        further: Vec<CandidateEffect>,
    ) -> Self {
        let survey = OperatingPoints::new(subject, fitted);
        let mut effects = fitted.effects.clone();
        let own = effects.len();
        let candidates = causes::candidates(&survey, fitted);
        effects.extend(candidates.into_iter().chain(further));
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
        let base = LinearModel::new(
            &fitted.whitening,
            &RowsByVarianceClass::new(&fitted.whitening, &jacobian),
            &residual,
            kept.iter().map(|k| priors[*k]).collect(),
            DVector::from_iterator(kept.len(), kept.iter().map(|k| fitted.x[*k])),
        );
        let columns = if columns.is_empty() {
            DMatrix::zeros(residual.len(), 0)
        } else {
            DMatrix::from_columns(&columns)
        };
        Self {
            fitted: Arc::clone(fitted),
            effects,
            own,
            ranges,
            columns,
            kept,
            base,
            jacobian,
            residual,
        }
    }

    /// Frees the memory of the columns. Existing reductions remain valid, but new ones can no longer be computed.
    pub(super) fn forget_columns(&mut self) {
        self.columns = DMatrix::zeros(0, 0);
        self.jacobian = DMatrix::zeros(0, 0);
    }

    /// Marginalises all unknowns except the parameters of effects, at the variance components `sizes`. Returns `None` if the linear model has no
    /// finite solution.
    pub(super) fn reduced(&self, sizes: &VarianceComponents) -> Option<Reduction> {
        let posterior = self.base.posterior(sizes)?;
        let weights = self.fitted.whitening.weights(&sizes.ln);
        let weighted = |mut columns: DMatrix<f64>| {
            for (mut row, weight) in columns.row_iter_mut().zip(weights.iter()) {
                row *= *weight;
            }
            columns
        };
        let E = weighted(self.columns.clone());
        let A = weighted(self.jacobian.clone());
        let z = self.residual.component_mul(&weights) - &A * &posterior.step;
        let cross = transposed(&A, &E);
        let absorbed = transposed(&posterior.covariance, &cross);
        Some(Reduction {
            ln_z: posterior.ln_z,
            information: transposed(&E, &E) - transposed(&cross, &absorbed),
            gradient: E.tr_mul(&z),
            step: posterior.step,
            absorbed,
        })
    }

    /// Returns start values of the fit's unknowns for a new fit with a set of effects: the optimum of the linear model with this set. Changes of
    /// unknowns without a tolerance group, such as logarithms of stiffnesses, are limited to `reach`. Parameters of the fit's effects keep their
    /// values if the effect is not in the set, or if the fit uses the logarithm of the parameter.
    pub(super) fn start(&self, reduction: &Reduction, set: &Conditioned, reach: f64) -> Vec<f64> {
        let mut step = reduction.step.clone();
        for (column, mean) in set.columns.iter().zip(set.mean.iter()) {
            step.axpy(-mean, &reduction.absorbed.column(*column), 1.0);
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
                let Some(mean) = value(range.start + n) else {
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
        reduction: &Reduction,
        set: &Conditioned,
        effect: usize,
    ) -> Vec<f64> {
        let mut column = self.ranges[effect].start;
        let mut step = reduction.step.clone();
        for (column, mean) in set.columns.iter().zip(set.mean.iter()) {
            step.axpy(-mean, &reduction.absorbed.column(*column), 1.0);
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

impl Reduction {
    /// Returns the posterior of the effects with these column ranges. Returns `None` if `1 + M` of these columns is not positive definite.
    pub(super) fn conditioned<'r>(
        &self,
        ranges: impl Iterator<Item = &'r Range<usize>>,
    ) -> Option<Conditioned> {
        let columns: Vec<usize> = ranges.flat_map(Range::clone).collect();
        let Q = self.block(&columns, &columns) + DMatrix::identity(columns.len(), columns.len());
        let factor = Cholesky::new(Q)?;
        let g = self.gradient.select_rows(&columns);
        let mean = factor.solve(&g);
        let ln_bayes_factor = 0.5 * g.dot(&mean) - half_ln_det(&factor);
        Some(Conditioned {
            columns,
            factor,
            mean,
            ln_bayes_factor,
        })
    }

    /// Returns the log Bayes factor for adding the columns in `range` to a set, and the posterior mean of their parameters in the enlarged set.
    pub(super) fn beside(
        &self,
        set: &Conditioned,
        range: &Range<usize>,
    ) -> Option<(f64, DVector<f64>)> {
        let own: Vec<usize> = range.clone().collect();
        let cross = self.block(&set.columns, &own);
        let mut Q = self.block(&own, &own) + DMatrix::identity(own.len(), own.len());
        let mut g = self.gradient.select_rows(&own);
        if !set.columns.is_empty() {
            Q -= cross.tr_mul(&set.factor.solve(&cross));
            g -= cross.tr_mul(&set.mean);
        }
        let factor = Cholesky::new(Q)?;
        let mean = factor.solve(&g);
        Some((0.5 * g.dot(&mean) - half_ln_det(&factor), mean))
    }

    fn block(&self, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(rows.len(), columns.len(), |i, j| {
            self.information[(rows[i], columns[j])]
        })
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
fn first_member(fitted: &FittedModel) -> usize {
    let members = fitted.priors.iter();
    members
        .clone()
        .position(|prior| prior.group.is_some())
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closure::Sets;
    use crate::diagnosis_problem::Data;
    use crate::fit::fit;
    use crate::settings::OCCAM_WINDOW_NATS;
    use crate::sought::tests::{of_the_axle, shipped_axle};

    /// Fits sets of effects. The evidence of each fit must equal the evidence of the same set in the linear model reduced at that fit.
    #[test]
    fn the_score_of_a_fitted_set_is_the_evidence_of_its_fit() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let (subject, none) = of_the_axle(&problem);
        let none = Arc::new(none);
        let model = EffectModel::new(&subject, &none, Vec::new());
        // Only effects whose prior is the same in a fit and in the linear model are compared: neither compliances nor slip lengths.
        let is_same = |k: &usize| {
            let numbers = &model.effects[*k].numbers;
            numbers.iter().all(|number| {
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
            let there = EffectModel::new(&subject, &fitted, Vec::new());
            let reduction = there.reduced(&fitted.sizes).expect("a finite model");
            let own: Vec<usize> = (0..there.own).collect();
            let sets = Sets::new(&there, &reduction);
            let score = sets.conditioned(&own).expect("positive").ln_bayes_factor;
            let reached = fitted.posterior.ln_z;
            assert!(
                (reduction.ln_z + score - reached).abs() < 1e-7,
                "{}: {} and {reached}",
                chosen
                    .iter()
                    .map(|(h, _)| h.to_string())
                    .collect::<Vec<_>>()
                    .join(", "),
                reduction.ln_z + score
            );
            compared += 1;
        }
        assert!(compared >= 2, "{compared}");
    }

    /// The closure must contain every pair of effects within Occam's window. The test uses a part of the catalogue.
    #[test]
    fn the_closure_holds_all_pairs_within_the_window() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let (subject, none) = of_the_axle(&problem);
        let none = Arc::new(none);
        let mut model = EffectModel::new(&subject, &none, Vec::new());
        let keep: Vec<usize> = (0..model.effects.len())
            .filter(|k| !model.effects[*k].is_poorly_linearised())
            .step_by(5)
            .collect();
        model.effects = keep.iter().map(|k| model.effects[*k].clone()).collect();
        model.ranges = keep.iter().map(|k| model.ranges[*k].clone()).collect();
        let reduction = model.reduced(&none.sizes).expect("a finite model");
        let sets = Sets::new(&model, &reduction);
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
