//! Information of the readings about the unknowns of a fit, with and without further measurements.
//!
//! Let `S` be the prior standard deviations and `H = A'W A` the information matrix of all readings.
//! The covariance of the unknowns is `S (I + S H S)^-1 S`. Tolerances, frame poses and positions of marks are unknowns, too, and are therefore
//! marginalised. A further measurement adds to `H`; nothing is refitted.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::prospect::Readings;
use admire_diagnosis::FittedModel;
use admire_identify::tolerance::transposed;

/// Information of readings and priors about the unknowns of a fit.
#[derive(Clone, Debug)]
pub(super) struct Information {
    H: DMatrix<f64>,
    /// Prior standard deviations of the unknowns.
    S: DVector<f64>,
}

impl Information {
    /// Returns the information of the readings of a fit.
    pub(super) fn of(fitted: &FittedModel) -> Self {
        let (_, J) = fitted.whitened();
        let priors = fitted.priors.iter().map(|p| p.prior_sd(&fitted.sizes));
        Self {
            H: transposed(&J, &J),
            S: DVector::from_iterator(fitted.priors.len(), priors),
        }
    }

    /// Appends the unknowns that a candidate introduces, given their prior standard deviations. The readings so far contain no information
    /// about them.
    #[must_use]
    pub(super) fn with_nuisance(&self, further: &[f64]) -> Self {
        let (n, k) = (self.S.len(), further.len());
        let mut S = self.S.clone().resize_vertically(n + k, 0.0);
        for (at, sd) in further.iter().enumerate() {
            S[n + at] = *sd;
        }
        Self {
            H: self.H.clone().resize(n + k, n + k, 0.0),
            S,
        }
    }

    /// Adds the information of a candidate's readings.
    #[must_use]
    pub(super) fn with(&self, readings: &Readings) -> Self {
        let mut new = self.with_nuisance(&readings.further);
        new.H += readings.jacobian.tr_mul(&readings.jacobian);
        if readings.replaced.nrows() > 0 {
            new.H -= readings.replaced.tr_mul(&readings.replaced);
        }
        new
    }

    /// Returns the matrix `Y` with `rows C rows' = Y'Y`, where `C` is the covariance of the unknowns. Each row of `rows` holds the
    /// coefficients of one linear combination of the leading unknowns.
    pub(super) fn root(&self, rows: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let n = self.S.len();
        let mut M = self.H.clone();
        for column in 0..n {
            for row in 0..n {
                M[(row, column)] *= self.S[row] * self.S[column];
            }
            M[(column, column)] += 1.0;
        }
        let mut right = DMatrix::zeros(n, rows.nrows());
        for column in 0..rows.ncols() {
            for row in 0..rows.nrows() {
                right[(column, row)] = rows[(row, column)] * self.S[column];
            }
        }
        let factor = Cholesky::new(M)?;
        factor.l_dirty().solve_lower_triangular(&right)
    }

    /// Returns the covariance matrix of linear combinations of the leading unknowns. Each row of `rows` holds the coefficients of one
    /// combination.
    pub(super) fn covariance(&self, rows: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let root = self.root(rows)?;
        Some(root.tr_mul(&root))
    }
}

/// Returns the log determinant of a covariance matrix, or `None` if the matrix is not positive definite.
pub(super) fn ln_det(covariance: &DMatrix<f64>) -> Option<f64> {
    let factor = Cholesky::new(covariance.clone())?;
    let diagonal = factor.l_dirty().diagonal();
    Some(2.0 * diagonal.iter().map(|d| libm::log(*d)).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_study::noise::Noise;

    /// Checks the covariance against the inverse of the full information matrix, and against Woodbury's formula for added readings.
    #[test]
    fn readings_add_information() {
        let mut noise = Noise::new(5, "information");
        let J = DMatrix::from_fn(30, 6, |_, _| noise.normal());
        let S = DVector::from_vec(vec![3.0, 3.0, 0.2, 0.1, 0.5, 1.0]);
        let before = Information {
            H: J.tr_mul(&J),
            S: S.clone(),
        };
        let own = DMatrix::from_diagonal(&S.map(|s| 1.0 / (s * s)));
        let rows = DMatrix::from_fn(4, 6, |_, _| noise.normal());
        let inverse = (before.H.clone() + &own).try_inverse().unwrap();
        let expected = &rows * &inverse * rows.transpose();
        let found = before.covariance(&rows).unwrap();
        assert!((&found - &expected).amax() < 1e-12 * expected.amax());

        let more = DMatrix::from_fn(5, 7, |_, _| noise.normal());
        let mut readings = Readings::new(more.clone(), DVector::zeros(5), vec![1.0; 5]);
        readings.further = vec![0.3];
        let mut C = inverse.resize(7, 7, 0.0);
        C[(6, 6)] = 0.09;
        let inner = DMatrix::identity(5, 5) + &more * &C * more.transpose();
        let gain = &C * more.transpose() * inner.try_inverse().unwrap() * &more * &C;
        let after = (C - gain).view((0, 0), (6, 6)).into_owned();
        let expected = &rows * after * rows.transpose();
        let with = before.with(&readings);
        let found = with.covariance(&rows).unwrap();
        assert!((&found - &expected).amax() < 1e-12 * expected.amax());
        // Subtracting the added rows restores the original covariance.
        let mut back = readings;
        back.replaced = more;
        let same = before.with(&back).covariance(&rows).unwrap();
        let was = before.covariance(&rows).unwrap();
        assert!((&same - &was).amax() < 1e-12 * was.amax());
        let values = ln_det(&was).unwrap();
        assert!((values - was.determinant().ln()).abs() < 1e-9);
    }
}
