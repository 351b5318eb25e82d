//! Evidence of a linear model with Gaussian priors whose standard deviations are unknown.
//!
//! The rows are independent and fall into a few classes of equal variance. One Gram matrix per class is then a sufficient statistic. A new
//! evaluation at other standard deviations ("sizes") costs only additions and one factorisation.
//!
//! Let `A` be the Jacobian, `W` the reciprocal variances of the rows, `H = A'W A`, and `S` the prior standard deviations of the unknowns. At
//! the linearisation point, `z` is the residual (reading minus prediction) and `x0` the deviation of the unknowns from their prior means. With
//! `M = I + S H S` and `b = S A'W z - x0/S`, the log evidence is, up to constants,
//!
//! `ln Z = -(z'W z + |x0/S|^2 - b'M^-1 b)/2 - ln det M / 2 - sum ln var / 2 + sum ln p(sizes)`.
//!
//! Source: MacKay, Neural Computation 4 (1992) 415.

use std::collections::BTreeMap;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::class_gram::ClassGram;
use super::columns::RowsByVarianceClass;
use super::cross_products::CrossProducts;
use super::factor::Factor;
use super::group::{EffectGroup, VarianceComponents};
use super::solution::Solution;
use super::whitening::Whitening;

/// Gaussian prior of one unknown of a linear model.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Coefficient {
    /// Mean of the prior.
    pub mean: f64,
    /// Prior standard deviation of the unknown itself. If the unknown belongs to a group, the standard deviation of the group is added in
    /// quadrature.
    pub sd: f64,
    /// Group of random effects that the unknown belongs to, if any.
    pub group: Option<EffectGroup>,
    /// Load case to which the effect of the unknown is confined; `None` if it acts in several cases.
    pub case: Option<usize>,
}

impl Coefficient {
    /// Returns the prior of a random effect in a group: mean zero, and the standard deviation of the group.
    pub const fn member(group: EffectGroup) -> Self {
        Self {
            mean: 0.0,
            sd: 0.0,
            group: Some(group),
            case: None,
        }
    }

    /// Returns the same prior for an effect that is confined to one load case.
    #[must_use]
    pub const fn in_case(self, case: Option<usize>) -> Self {
        Self { case, ..self }
    }

    /// Returns the prior standard deviation of the unknown at the variance components `sizes`.
    pub fn prior_sd(&self, sizes: &VarianceComponents) -> f64 {
        let tau = self.group.and_then(|group| sizes.of(group)).unwrap_or(0.0);
        libm::hypot(tau, self.sd)
    }
}

/// A linearised model, stored as the Gram matrices of its whitened rows.
#[derive(Clone, Debug)]
pub struct LinearModel {
    shares: Vec<ClassGram>,
    /// Prior of each unknown, one per column of the Jacobian.
    pub unknowns: Vec<Coefficient>,
    /// Linearisation point: the values of the unknowns there.
    pub at: DVector<f64>,
}

/// Posterior of the unknowns of a linear model at given variance components.
#[derive(Clone, Debug)]
pub struct Posterior {
    /// Log evidence plus the log prior density of the variance components.
    pub ln_z: f64,
    /// Step from the linearisation point to the posterior maximum.
    pub step: DVector<f64>,
    /// Posterior covariance of the unknowns.
    pub covariance: DMatrix<f64>,
    /// Sum of squared whitened residuals at the maximum, without prior terms.
    pub chi_square: f64,
    /// Effective number of parameters: number of unknowns that the readings rather than the priors determine.
    pub effective: f64,
    /// Number of rows that are used.
    pub count: f64,
    /// Predicted decrease of the negative log posterior by `step`, in nats.
    pub gain: f64,
    /// Logarithms of the standard deviations (variance components) at which the posterior was computed.
    pub ln: Vec<f64>,
}

impl Posterior {
    /// Returns chi-square per degree of freedom. The degrees of freedom are `count - effective`.
    pub fn chi_square_per_dof(&self) -> f64 {
        self.chi_square / (self.count - self.effective).max(1.0)
    }

    /// Returns the variances that the unknowns in `kept` would have if all other unknowns were known exactly. If the other unknowns are the
    /// tolerances, the difference to the full variance is the contribution of the tolerances.
    pub fn without(&self, kept: &[usize]) -> Vec<f64> {
        // If the other unknowns are fixed, the precision of the kept unknowns is their block of the inverse covariance.
        let Some(all) = Cholesky::new(self.covariance.clone()) else {
            return kept.iter().map(|k| self.covariance[(*k, *k)]).collect();
        };
        let precision = all.inverse();
        let block = precision.select_rows(kept).select_columns(kept);
        match Cholesky::new(block) {
            Some(block) => block.inverse().diagonal().iter().copied().collect(),
            None => kept.iter().map(|k| self.covariance[(*k, *k)]).collect(),
        }
    }
}

impl LinearModel {
    /// Builds the model from whitened rows (see [`Whitening::apply`]). `residual` is reading minus prediction, and `at` is the linearisation
    /// point.
    pub fn new(
        whitening: &Whitening,
        jacobian: &RowsByVarianceClass,
        residual: &DVector<f64>,
        unknowns: Vec<Coefficient>,
        at: DVector<f64>,
    ) -> Self {
        let classes = whitening.classes.iter().zip(&whitening.rows_of);
        let shares = classes.zip(&jacobian.classes).map(|((class, rows), A)| {
            ClassGram::new(class.clone(), A, &residual.select_rows(rows))
        });
        Self {
            shares: shares.collect(),
            unknowns,
            at,
        }
    }

    /// Returns the model with one set of `further` columns appended. The set has the index `set` and `count` columns. Each new unknown has the
    /// prior `unknown` and is zero at the linearisation point.
    #[must_use]
    pub fn with(
        &self,
        further: &CrossProducts,
        set: usize,
        count: usize,
        unknown: Coefficient,
    ) -> Self {
        let n = self.unknowns.len();
        let shares = self.shares.iter().zip(further.blocks(set));
        let mut new = Self {
            shares: shares.map(|(share, block)| share.with(n, &block)).collect(),
            unknowns: self.unknowns.clone(),
            at: self.at.clone().resize_vertically(n + count, 0.0),
        };
        new.unknowns.resize(n + count, unknown);
        new
    }

    /// Returns the model linearised again at `at`, with a new residual and with new values of the columns listed in `changed`.
    ///
    /// `changed` is in ascending order. `own` holds the new values of these columns; `jacobian` holds the values of all other columns.
    #[must_use]
    pub fn moved(
        &self,
        whitening: &Whitening,
        jacobian: &RowsByVarianceClass,
        changed: &[usize],
        own: &RowsByVarianceClass,
        residual: &DVector<f64>,
        at: DVector<f64>,
    ) -> Self {
        let columns = jacobian.classes.iter().zip(&own.classes);
        let shares = self.shares.iter().zip(&whitening.rows_of).zip(columns);
        let shares = shares.map(|((share, rows), (A, own))| {
            share.moved(A, changed, own, &residual.select_rows(rows))
        });
        Self {
            shares: shares.collect(),
            unknowns: self.unknowns.clone(),
            at,
        }
    }

    /// Returns the model without the rows marked in `left_out`. `turned` is the whitened Jacobian of all rows, and `residual` is reading minus
    /// prediction.
    #[must_use]
    pub fn without(
        &self,
        whitening: &Whitening,
        turned: &DMatrix<f64>,
        residual: &DVector<f64>,
        left_out: &[bool],
    ) -> Self {
        let of_class = |rows: &Vec<usize>| {
            let rows = rows.iter().filter(|row| left_out[**row]);
            rows.copied().collect::<Vec<usize>>()
        };
        let rows_of: Vec<Vec<usize>> = whitening.rows_of.iter().map(of_class).collect();
        let columns = RowsByVarianceClass::of_rows(&rows_of, turned);
        let shares = self.shares.iter().zip(&rows_of).zip(&columns.classes);
        let rest = shares.map(|((share, rows), A)| {
            let out = ClassGram::new(share.class.clone(), A, &residual.select_rows(rows));
            share.less(&out)
        });
        Self {
            shares: rest.collect(),
            unknowns: self.unknowns.clone(),
            at: self.at.clone(),
        }
    }

    /// Returns the lower triangle of the information `A'W A`, then `A'W z`, `z'W z`, and the sum of the logarithms of the variances of all
    /// rows, at the log standard deviations `ln`.
    fn sums(&self, ln: &[f64]) -> (DMatrix<f64>, DVector<f64>, f64, f64) {
        let n = self.unknowns.len();
        let (mut H, mut g) = (DMatrix::zeros(n, n), DVector::zeros(n));
        let (mut q, mut logs) = (0.0, 0.0);
        for share in &self.shares {
            let variance = share.class.variance(ln);
            share.add_to(1.0 / variance, &mut H, &mut g);
            q += share.q / variance;
            logs += share.count * libm::log(variance);
        }
        (H, g, q, logs)
    }

    fn prior_sds(&self, sizes: &VarianceComponents) -> DVector<f64> {
        DVector::from_iterator(
            self.unknowns.len(),
            self.unknowns.iter().map(|unknown| unknown.prior_sd(sizes)),
        )
    }

    /// Solves the linear model at the variance components `sizes`. `damping` is added to the diagonal of `M`. Returns `None` if `M` is not
    /// positive definite.
    fn solved(&self, sizes: &VarianceComponents, damping: f64) -> Option<Solved> {
        let S = self.prior_sds(sizes);
        let (mut M, g, q, logs) = self.sums(&sizes.ln);
        let n = S.len();
        for k in 0..n {
            let column = &mut M.as_mut_slice()[k * n..(k + 1) * n];
            for (value, s) in column[k..].iter_mut().zip(&S.as_slice()[k..]) {
                *value *= S[k] * s;
            }
            column[k] += 1.0 + damping;
        }
        let from = DVector::from_fn(n, |k, _| {
            if S[k] > 0.0 {
                (self.at[k] - self.unknowns[k].mean) / S[k]
            } else {
                0.0
            }
        });
        let b = g.component_mul(&S) - &from;
        let factor = Factor::with_blocks(M, &blocks_of(&self.unknowns))?;
        let mu = factor.solve(&b);
        let prior: f64 = sizes
            .ln
            .iter()
            .zip(sizes.each())
            .map(|(ln, size)| size.ln_prior(*ln))
            .sum();
        let ln_z =
            -0.5 * (q + from.norm_squared() - b.dot(&mu)) - 0.5 * factor.ln_det() - 0.5 * logs
                + prior;
        Some(Solved {
            factor,
            S,
            mu,
            from,
            b,
            ln_z,
        })
    }

    /// Returns the log evidence at the variance components `sizes`.
    #[cfg(test)]
    fn ln_z(&self, sizes: &VarianceComponents) -> f64 {
        self.solved(sizes, 0.0)
            .map_or(f64::NEG_INFINITY, |solved| solved.ln_z)
    }

    /// Returns the log evidence, its gradient with respect to the log standard deviations, and the diagonal of their Fisher information. The
    /// contribution of the noise to the information is included only if `with_information` is true. Returns `None` if the model cannot be
    /// solved.
    pub(crate) fn evidence(
        &self,
        sizes: &VarianceComponents,
        with_information: bool,
    ) -> Option<(f64, Vec<f64>, Vec<f64>)> {
        let solved = self.solved(sizes, 0.0)?;
        let mut inverse = solved.factor.inverse();
        let (S, mu) = (&solved.S, &solved.mu);
        let n = S.len();
        let mut gradient: Vec<f64> = sizes
            .ln
            .iter()
            .zip(sizes.each())
            .map(|(ln, size)| -(ln - libm::log(size.median)) / (size.ln_sd * size.ln_sd))
            .collect();
        let mut information: Vec<f64> = sizes.each().map(|size| size.ln_sd.powi(-2)).collect();
        for (k, unknown) in self.unknowns.iter().enumerate() {
            let Some(at) = unknown.group.and_then(|group| sizes.group(group)) else {
                continue;
            };
            let phi = libm::exp(2.0 * sizes.ln[at]) / (S[k] * S[k]).max(f64::MIN_POSITIVE);
            // Deviation of the unknown from its prior mean at the maximum, in prior standard deviations.
            let end = solved.from[k] + mu[k];
            gradient[at] += phi * (end * end + inverse[(k, k)] - 1.0);
            information[at] += 2.0 * (phi * (1.0 - inverse[(k, k)])).powi(2);
        }
        let step = mu.component_mul(S);
        // Lower triangle of the covariance with doubled off-diagonal entries, because products with symmetric matrices read only one triangle.
        for k in 0..n {
            let column = &mut inverse.as_mut_slice()[k * n..(k + 1) * n];
            for (value, s) in column[k..].iter_mut().zip(&S.as_slice()[k..]) {
                *value *= 2.0 * S[k] * s;
            }
            column[k] *= 0.5;
        }
        let covariance = inverse;
        for share in &self.shares {
            let by = share.class.by_size(&sizes.ln);
            if by.is_empty() {
                continue;
            }
            let variance = share.class.variance(&sizes.ln);
            let spread = share.product(&covariance);
            let expected = share.left(&step) + spread;
            let rate = 0.5 * (expected / variance - share.count) / variance;
            for (at, by) in &by {
                gradient[*at] += rate * by;
            }
            if with_information {
                let free = (share.count - spread / variance).max(0.0);
                for (at, by) in by {
                    information[at] += 0.5 * free * (by / variance).powi(2);
                }
            }
        }
        Some((solved.ln_z, gradient, information))
    }

    /// Returns the posterior of the unknowns at the variance components `sizes`; `None` if the model has no finite solution.
    pub fn posterior(&self, sizes: &VarianceComponents) -> Option<Posterior> {
        let solved = self.solved(sizes, 0.0)?;
        let inverse = solved.factor.inverse();
        let S = &solved.S;
        let n = S.len();
        let effective = (0..n)
            .filter(|k| S[*k] > 0.0)
            .map(|k| 1.0 - inverse[(k, k)])
            .sum();
        let mut covariance = inverse;
        for k in 0..n {
            for row in k..n {
                let value = covariance[(row, k)] * S[row] * S[k];
                covariance[(row, k)] = value;
                covariance[(k, row)] = value;
            }
        }
        let reached = solved.reached()?;
        let chi_square = self
            .shares
            .iter()
            .map(|share| share.left(&reached.step).max(0.0) / share.class.variance(&sizes.ln))
            .sum();
        Some(Posterior {
            ln_z: reached.ln_z,
            gain: reached.gain,
            step: reached.step,
            covariance,
            chi_square,
            effective,
            count: self.shares.iter().map(|share| share.count).sum(),
            ln: sizes.ln.clone(),
        })
    }

    /// Returns the posterior maximum with Levenberg-Marquardt damping. The damping acts as an additional Gaussian prior of each unknown,
    /// centred at the linearisation point. This prior is `1 / sqrt(damping)` times as wide as the unknown's own prior.
    pub fn solve(&self, sizes: &VarianceComponents, damping: f64) -> Option<Solution> {
        self.solved(sizes, damping)?.reached()
    }

    /// Returns the objective `z'W z + |x0/S|^2` at the linearisation point: chi-square plus the prior terms.
    pub fn objective(&self, sizes: &VarianceComponents) -> f64 {
        let S = self.prior_sds(sizes);
        let data: f64 = self
            .shares
            .iter()
            .map(|share| share.q / share.class.variance(&sizes.ln))
            .sum();
        let prior: f64 = (0..S.len())
            .filter(|k| S[*k] > 0.0)
            .map(|k| ((self.at[k] - self.unknowns[k].mean) / S[k]).powi(2))
            .sum();
        data + prior
    }

    /// Returns the variance components of maximum evidence. The search starts from `sizes`.
    pub fn maximise_evidence(&self, sizes: &VarianceComponents) -> VarianceComponents {
        super::maximise_evidence::climb(sizes, |sizes, first| self.evidence(sizes, first))
    }
}

/// Returns the indices of the unknowns that are confined to single load cases, case by case. Those of different cases are coupled only through
/// all other unknowns.
fn blocks_of(unknowns: &[Coefficient]) -> Vec<Vec<usize>> {
    let mut by_case: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (k, unknown) in unknowns.iter().enumerate() {
        if let Some(case) = unknown.case {
            by_case.entry(case).or_default().push(k);
        }
    }
    by_case.into_values().collect()
}

/// Solution of a linear model at given variance components, in the notation of the module documentation.
struct Solved {
    /// Cholesky factor of `M`.
    factor: Factor,
    S: DVector<f64>,
    /// `M^-1 b`.
    mu: DVector<f64>,
    /// `x0 / S`.
    from: DVector<f64>,
    b: DVector<f64>,
    ln_z: f64,
}

impl Solved {
    fn reached(self) -> Option<Solution> {
        let step = self.mu.component_mul(&self.S);
        let finite = step.iter().all(|x| x.is_finite()) && self.ln_z.is_finite();
        finite.then(|| Solution {
            ln_z: self.ln_z,
            gain: 0.5 * self.b.dot(&self.mu).max(0.0),
            step,
            factor: self.factor,
            S: self.S,
        })
    }
}

#[cfg(test)]
mod tests;
