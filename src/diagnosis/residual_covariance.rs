//! Covariance of the residuals of a fit, and score tests of contrasts (weighted sums of residual rows).

use nalgebra::{Cholesky, DMatrix, DVector};

use super::fit::FittedModel;
use admire_identify::ChiSquare;
use admire_identify::settings::ABSORBED_VARIANCE_SHARE;
use admire_identify::tolerance::{Factor, covariance_root, transposed};

/// Contrast: pairs of row index and weight.
pub(super) type Contrast = Vec<(usize, f64)>;

/// Whitened residuals of a fit, with their covariance `Cov(r) = I - Q Q^T`. Here `Q = J L`, and `L L^T` is the posterior covariance. Source:
/// the marginal likelihood of a linear model with Gaussian priors.
pub(super) struct ResidualCovariance<'a> {
    fitted: &'a FittedModel,
    weights: DVector<f64>,
    /// Whitened residual: reading minus prediction.
    pub residual: DVector<f64>,
    /// Transpose `Q^T` of the matrix `Q` in the covariance, with one column per residual row.
    Q: DMatrix<f64>,
}

impl<'a> ResidualCovariance<'a> {
    /// Computes the residual covariance of a fit. Rows that the fit did not use are excluded.
    pub(super) fn new(fitted: &'a FittedModel) -> Self {
        let (residual, J) = fitted.whitened();
        let (covariance, step) = with_wide_priors(fitted);
        Self {
            weights: fitted.whitening.weights(&fitted.sizes.ln),
            residual: residual - &J * step,
            Q: (J * covariance_root(&covariance)).transpose(),
            fitted,
        }
    }

    /// Returns the chi-square of the given residual rows under their covariance. Returns `None` if the fit used none of these rows.
    pub(super) fn test_rows(&self, rows: &[usize]) -> Option<ChiSquare> {
        let rows: Vec<usize> = rows
            .iter()
            .copied()
            .filter(|row| self.weights[*row] > 0.0)
            .collect();
        if rows.is_empty() {
            return None;
        }
        let Q = self.Q.select_columns(&rows);
        scatter(&Q, &self.residual.select_rows(&rows))
    }

    /// Returns the score test of these contrasts, which are patterns of change of the readings. The test detects components of the residuals
    /// that noise and tolerances do not explain.
    pub(super) fn test(&self, contrasts: &[Contrast]) -> Option<ChiSquare> {
        self.score(contrasts).statistic()
    }

    /// Projects the residuals and their covariance on these contrasts.
    fn score(&self, contrasts: &[Contrast]) -> Along {
        let k = contrasts.len();
        let mut s = DVector::zeros(k);
        let mut QX = DMatrix::zeros(self.Q.nrows(), k);
        let mut dense: Vec<std::collections::BTreeMap<usize, f64>> = Vec::with_capacity(k);
        for (c, contrast) in contrasts.iter().enumerate() {
            let mut own = self.fitted.whitening.apply_sparse(contrast);
            own.retain(|row, weight| {
                *weight *= self.weights[*row];
                *weight != 0.0
            });
            for (row, weight) in &own {
                s[c] += weight * self.residual[*row];
                QX.column_mut(c).axpy(*weight, &self.Q.column(*row), 1.0);
            }
            dense.push(own);
        }
        let mut own = DMatrix::zeros(k, k);
        for a in 0..k {
            for b in 0..=a {
                let (small, large) = if dense[a].len() < dense[b].len() {
                    (&dense[a], &dense[b])
                } else {
                    (&dense[b], &dense[a])
                };
                let sum: f64 = small
                    .iter()
                    .filter_map(|(row, w)| Some(w * large.get(row)?))
                    .sum();
                own[(a, b)] = sum;
                own[(b, a)] = sum;
            }
        }
        Along { s, QX, own }
    }

    /// Projects the residuals on the contrasts of each case separately, so that weighted sums over the cases can be tested.
    pub(super) fn by_case(&self, cases: &[Vec<Contrast>]) -> ByCase {
        ByCase(cases.iter().map(|case| self.score(case)).collect())
    }
}

/// Projections on contrasts with the whitened columns `X`: `X'r`, `Q'X` and `X'X`.
struct Along {
    s: DVector<f64>,
    QX: DMatrix<f64>,
    own: DMatrix<f64>,
}

impl Along {
    /// Returns the score test of the contrasts that involve rows used in the fit.
    fn statistic(&self) -> Option<ChiSquare> {
        let used: Vec<usize> = (0..self.s.len())
            .filter(|c| self.own[(*c, *c)] > 0.0)
            .collect();
        if used.is_empty() {
            return None;
        }
        let QX = self.QX.select_columns(&used);
        let mut A = self.own.select_rows(&used).select_columns(&used) - transposed(&QX, &QX);
        let mut s = self.s.select_rows(&used);
        // Columns are scaled to unit norm, so that the fractions absorbed by the fit are comparable.
        for (c, at) in used.iter().enumerate() {
            let norm = self.own[(*at, *at)].sqrt();
            s[c] /= norm;
            A.column_mut(c).scale_mut(1.0 / norm);
            A.row_mut(c).scale_mut(1.0 / norm);
        }
        statistic(A, &s)
    }
}

/// Projections on the same contrasts in every case. Rows of different cases are independent, so weighted sums over the cases need only these
/// projections.
pub(super) struct ByCase(Vec<Along>);

impl ByCase {
    /// Returns the score test of the contrasts summed over the cases, with one weight per case.
    pub(super) fn test(&self, weights: &[f64]) -> Option<ChiSquare> {
        let first = self.0.first()?;
        let mut sum = Along {
            s: DVector::zeros(first.s.len()),
            QX: DMatrix::zeros(first.QX.nrows(), first.s.len()),
            own: DMatrix::zeros(first.s.len(), first.s.len()),
        };
        for (case, weight) in self.0.iter().zip(weights) {
            sum.s.axpy(*weight, &case.s, 1.0);
            for (to, from) in [
                (&mut sum.QX, (&case.QX, *weight)),
                (&mut sum.own, (&case.own, weight * weight)),
            ] {
                let (values, weight) = from;
                for (to, value) in to.iter_mut().zip(values.iter()) {
                    *to += weight * value;
                }
            }
        }
        sum.statistic()
    }
}

/// Returns the chi-square `r'(c - Q'Q)^-1 r` of some rows, whose residual covariance is `1 - Q'Q`. The factor `c` is slightly larger than
/// one. If there are more rows than unknowns, `(c - Q'Q)^-1 = (1 + Q'(c - QQ')^-1 Q)/c` requires only a factor of the smaller matrix `c -
/// QQ'`.
fn scatter(Q: &DMatrix<f64>, r: &DVector<f64>) -> Option<ChiSquare> {
    let c = 1.0 + ABSORBED_VARIANCE_SHARE;
    let rest = |squares: DMatrix<f64>| {
        let n = squares.nrows();
        Factor::new(DMatrix::identity(n, n) * c - squares)
    };
    let count = r.len() as f64;
    let (value, trace) = if r.len() < Q.nrows() {
        let factor = rest(transposed(Q, Q))?;
        (r.dot(&factor.solve(r)), factor.inverse_trace())
    } else {
        let factor = rest(Q * Q.transpose())?;
        let along = Q * r;
        let value = (r.norm_squared() + along.dot(&factor.solve(&along))) / c;
        // Since `QQ' = c - rest`, the trace of `rest^-1 QQ'` follows from the trace of `rest^-1`.
        let solved = c * factor.inverse_trace() - Q.nrows() as f64;
        (value, (count + solved) / c)
    };
    let dof = (count - ABSORBED_VARIANCE_SHARE * trace).round();
    (dof > 0.0 && value.is_finite()).then_some(ChiSquare {
        value,
        dof: dof as usize,
    })
}

/// Returns `s^T A^-1 s`. A ridge of [`ABSORBED_VARIANCE_SHARE`] is added to `A`, which suppresses directions that the fit has absorbed.
fn statistic(A: DMatrix<f64>, s: &DVector<f64>) -> Option<ChiSquare> {
    let k = s.len();
    let inverse = Cholesky::new(A + DMatrix::identity(k, k) * ABSORBED_VARIANCE_SHARE)?.inverse();
    let value = s.dot(&(&inverse * s));
    let dof = (k as f64 - ABSORBED_VARIANCE_SHARE * inverse.trace()).round();
    (dof > 0.0 && value.is_finite()).then_some(ChiSquare {
        value,
        dof: dof as usize,
    })
}

/// Returns the posterior covariance and the step to the posterior mode, with wider priors of the causes' parameters. Each prior standard
/// deviation is raised to the distance of the estimate from the prior mean. Otherwise a cause far larger than its prior would leave
/// structure along its own effect. The priors are replaced one after the other by the Sherman-Morrison formula.
fn with_wide_priors(fitted: &FittedModel) -> (DMatrix<f64>, DVector<f64>) {
    let mut covariance = fitted.posterior.covariance.clone();
    let mut step = DVector::zeros(covariance.nrows());
    for at in fitted.parameter_index.iter().flatten() {
        let prior = &fitted.priors[*at];
        let off: f64 = fitted.x[*at] + fitted.posterior.step[*at] + step[*at] - prior.mean;
        let precision = prior.prior_sd(&fitted.sizes).powi(-2);
        let less = precision - off.powi(-2);
        if less > 0.0 && less.is_finite() {
            let column = covariance.column(*at).clone_owned();
            let scale = less / (1.0 - less * column[*at]);
            covariance.ger(scale, &column, &column, 1.0);
            step.axpy(scale * off, &column, 1.0);
        }
    }
    (covariance, step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_solver::mechanics::eigen::singular_values;
    use admire_study::noise::Noise;

    /// Checks the statistic against the inverse of the full covariance matrix, with fewer unknowns than rows and with more.
    #[test]
    fn scatter_is_that_by_the_inverse_of_the_covariance() {
        for (unknowns, rows) in [(4, 9), (9, 4)] {
            let mut noise = Noise::new(7, "scatter");
            let r = DVector::from_fn(rows, |_, _| noise.normal());
            let mut Q = DMatrix::from_fn(unknowns, rows, |_, _| noise.normal());
            let values = singular_values(Q.clone(), false, false).unwrap();
            Q *= 0.99 / values.singular_values.max();
            let covariance =
                DMatrix::identity(rows, rows) * (1.0 + ABSORBED_VARIANCE_SHARE) - Q.tr_mul(&Q);
            let inverse = covariance.try_inverse().unwrap();
            let found = scatter(&Q, &r).unwrap();
            let value = r.dot(&(&inverse * &r));
            assert!(
                (found.value / value - 1.0).abs() < 1e-9,
                "{found:?} {value}"
            );
            let dof = rows as f64 - ABSORBED_VARIANCE_SHARE * inverse.trace();
            assert_eq!(found.dof, dof.round() as usize);
        }
    }
}
