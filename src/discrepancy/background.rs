//! Small errors that every deck and every rig has: hardpoints measured to a tenth of a millimetre, loads to a third of a percent.
//!
//! They are no unknowns of the fit, which would move every marker of the deck: their effect on the readings, to first order, is part of
//! the noise, `S = I + V V^T` with one column of `V` for each error of one standard deviation. Rows are whitened by `S^(-1/2) = I - B
//! B^T`, which costs little because the errors are few. A hardpoint or a gain is a finding only beyond them.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::extended::Fitted;
use super::hypothesis::{Column, Hypothesis, Number, background};
use super::subject::{Data, Subject};
use super::survey::Survey;

/// Whitens rows.
#[derive(Clone, Debug)]
pub struct Background {
    V: DMatrix<f64>,
    B: DMatrix<f64>,
    /// `S^-1 = I - C C^T`.
    C: DMatrix<f64>,
}

impl Background {
    /// The errors of a deck at a fit, as far as they act on the rows that fits of this data see.
    pub fn new(subject: &Subject<'_>, fitted: &Fitted, data: Data) -> Self {
        let survey = Survey::new(subject, fitted);
        let numbers: Vec<Number> = background(&survey)
            .into_iter()
            .filter(|number| !matches!(number.column, Column::Rows(_)))
            .collect();
        let errors = Hypothesis::of_numbers(numbers);
        let mut V = survey.columns(&[errors]).solved;
        let weights = subject.weights(data);
        for (mut row, weight) in V.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        Self::of(V)
    }

    fn of(V: DMatrix<f64>) -> Self {
        let (mut B, mut C) = (V.clone(), V.clone());
        if V.ncols() > 0 {
            // V^T V = U L U^T, so that V U has orthogonal columns of squared lengths L.
            let eigen = SymmetricEigen::new(V.tr_mul(&V));
            let turned = &V * &eigen.eigenvectors;
            (B, C) = (turned.clone(), turned);
            for (k, &l) in eigen.eigenvalues.iter().enumerate() {
                let l = l.max(0.0);
                let (b, c) = if l > 1e-12 {
                    ((1.0 - (1.0 + l).powf(-0.5)) / l, 1.0 / (1.0 + l))
                } else {
                    (0.5, 1.0)
                };
                B.column_mut(k).scale_mut(b.sqrt());
                C.column_mut(k).scale_mut(c.sqrt());
            }
        }
        Self { V, B, C }
    }

    /// What the errors cost as part of the noise: `ln det S`, the unknowns of a fit without them integrated out. With the fall of
    /// chi-square it is twice the logarithm of how much likelier the readings are without them.
    pub fn cost(&self, fitted: &Fitted) -> f64 {
        let cross = self.V.tr_mul(&fitted.minimum.evaluation.jacobian);
        let n = self.V.ncols();
        let left = DMatrix::identity(n, n) + self.V.tr_mul(&self.V)
            - &cross * fitted.covariance() * cross.transpose();
        let eigenvalues = left.symmetric_eigenvalues();
        eigenvalues.iter().map(|l| l.max(1.0).ln()).sum()
    }

    /// Replaces residuals by whitened ones.
    pub fn whiten(&self, rows: &mut DVector<f64>) {
        *rows -= &self.B * self.B.tr_mul(rows);
    }

    /// The same for each column.
    pub fn whiten_columns(&self, columns: &mut DMatrix<f64>) {
        *columns -= &self.B * self.B.tr_mul(columns);
    }

    /// `x^T S^-1 y` of two columns that are not whitened yet and live on a few rows.
    pub fn dot(&self, a: &[(usize, f64)], b: &[(usize, f64)]) -> f64 {
        let sum = |rows: &[(usize, f64)]| {
            let mut out = DVector::zeros(self.C.ncols());
            for (row, value) in rows {
                out.axpy(*value, &self.C.row(*row).transpose(), 1.0);
            }
            out
        };
        sum(a).dot(&sum(b))
    }

    /// Covariance of the errors on these rows.
    pub fn covariance(&self, rows: &[usize]) -> DMatrix<f64> {
        let V = self.V.select_rows(rows);
        &V * V.transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whitening with `B` and the product with `C` are both `S^-1`.
    #[test]
    fn whitened_rows_have_the_inverse_covariance() {
        let V = DMatrix::from_row_slice(4, 2, &[1.0, 0.5, -2.0, 0.1, 0.3, 0.0, 0.0, 4.0]);
        let S = DMatrix::identity(4, 4) + &V * V.transpose();
        let inverse = S.try_inverse().unwrap();
        let background = Background::of(V);
        let mut W = DMatrix::identity(4, 4);
        background.whiten_columns(&mut W);
        assert!((&W * &W - &inverse).norm() < 1e-12);
        let (a, b) = ([(0, 2.0), (3, -1.0)], [(1, 0.5)]);
        let expected = 2.0 * 0.5 * inverse[(0, 1)] - 0.5 * inverse[(3, 1)];
        assert!((-background.dot(&a, &b) - expected).abs() < 1e-12);
    }
}
