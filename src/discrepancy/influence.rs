//! What a fit leaves in its residuals: their covariance, contrasts of them, and what each case says when the others predict it.

use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};

use super::extended::Fitted;
use crate::rig::orientation::chi_square_p_value;

/// A column of a contrast: rows and their weights.
pub type Contrast = Vec<(usize, f64)>;

/// Contrasts that the fit has absorbed up to so little are none: there a fit that stopped a little short of its minimum shows.
const ABSORBED: f64 = 0.01;
/// The same for a case that alone determines an unknown.
const ALONE: f64 = 1e-4;

/// The residuals of a fit and the share of each row that its unknowns took: `Cov(r) = I - Q Q^T` with `Q = J L`, `L L^T` the
/// posterior covariance. Source: the marginal likelihood of a linear model with Gaussian priors.
pub struct Influence<'a> {
    fitted: &'a Fitted,
    Q: DMatrix<f64>,
}

/// A chi-square statistic.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Statistic {
    /// Its value.
    pub value: f64,
    /// Degrees of freedom.
    pub dof: usize,
}

impl Statistic {
    /// Its p-value.
    pub fn p_value(self) -> f64 {
        chi_square_p_value(self.value, self.dof)
    }
}

impl<'a> Influence<'a> {
    /// Of a fit. Rows it has not seen take no part.
    pub fn new(fitted: &'a Fitted) -> Self {
        let covariance = fitted.covariance();
        let L = root(&covariance);
        let mut J = fitted.minimum.evaluation.jacobian.clone();
        for (mut row, weight) in J.row_iter_mut().zip(fitted.weights.iter()) {
            row *= *weight;
        }
        Self { fitted, Q: J * L }
    }

    /// True if the fit has seen a row.
    pub fn sees(&self, row: usize) -> bool {
        self.fitted.weights[row] > 0.0
    }

    /// Score test of these contrasts: whether the residuals have a component along any of them that noise does not explain.
    pub fn test(&self, contrasts: &[Contrast]) -> Option<Statistic> {
        let r = &self.fitted.minimum.evaluation.residual;
        let k = contrasts.len();
        if k == 0 {
            return None;
        }
        let mut s = DVector::zeros(k);
        let mut QX = DMatrix::zeros(self.Q.ncols(), k);
        let mut dense: Vec<std::collections::BTreeMap<usize, f64>> = Vec::with_capacity(k);
        for (c, contrast) in contrasts.iter().enumerate() {
            let mut own = std::collections::BTreeMap::new();
            for (row, weight) in contrast.iter().filter(|(row, _)| self.sees(*row)) {
                s[c] += weight * r[*row];
                *own.entry(*row).or_insert(0.0) += weight;
                for (to, q) in QX.column_mut(c).iter_mut().zip(self.Q.row(*row).iter()) {
                    *to += weight * q;
                }
            }
            dense.push(own);
        }
        let mut A = -QX.tr_mul(&QX);
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
                A[(a, b)] += sum;
                if a != b {
                    A[(b, a)] += sum;
                }
            }
        }
        // Columns to one scale, so that what is absorbed can be told.
        for c in 0..k {
            let norm = dense[c].values().map(|w| w * w).sum::<f64>().sqrt();
            if norm > 0.0 {
                s[c] /= norm;
                A.column_mut(c).scale_mut(1.0 / norm);
                A.row_mut(c).scale_mut(1.0 / norm);
            }
        }
        statistic(A, &s)
    }

    /// Minus twice the log of the density of each case's readings under the fit of all others, constants left out: `r_c^T (I -
    /// H_cc)^-1 r_c - ln det(I - H_cc)`. Exact for a linear model; no refit is needed.
    pub fn left_out(&self, cases: &[Vec<usize>]) -> f64 {
        let r = &self.fitted.minimum.evaluation.residual;
        cases
            .iter()
            .map(|rows| {
                let rows: Vec<usize> = rows.iter().copied().filter(|k| self.sees(*k)).collect();
                let Q = self.Q.select_rows(&rows);
                let own = DVector::from_iterator(rows.len(), rows.iter().map(|k| r[*k]));
                let rest =
                    DMatrix::identity(rows.len(), rows.len()) * (1.0 + ALONE) - &Q * Q.transpose();
                let Some(factor) = Cholesky::new(rest) else {
                    return f64::INFINITY;
                };
                let log_det: f64 = factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum();
                own.dot(&factor.solve(&own)) - 2.0 * log_det
            })
            .sum()
    }
}

/// `s^T A^-1 s` over what of `A` is not absorbed, softly: directions of which less than [`ABSORBED`] is left do not count.
fn statistic(A: DMatrix<f64>, s: &DVector<f64>) -> Option<Statistic> {
    let k = s.len();
    let inverse = Cholesky::new(A + DMatrix::identity(k, k) * ABSORBED)?.inverse();
    let value = s.dot(&(&inverse * s));
    let dof = (k as f64 - ABSORBED * inverse.trace()).round();
    (dof > 0.0 && value.is_finite()).then_some(Statistic {
        value,
        dof: dof as usize,
    })
}

/// `L` with `L L^T = C`, by Cholesky where it is definite.
fn root(C: &DMatrix<f64>) -> DMatrix<f64> {
    if let Some(factor) = Cholesky::new(C.clone()) {
        return factor.l();
    }
    if C.is_empty() {
        return C.clone();
    }
    let eigen = SymmetricEigen::new(C.clone());
    let mut L = eigen.eigenvectors;
    for (mut column, lambda) in L.column_iter_mut().zip(eigen.eigenvalues.iter()) {
        column *= lambda.max(0.0).sqrt();
    }
    L
}
