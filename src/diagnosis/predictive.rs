//! Posterior predictive distribution of readings that a fit did not use: whitened rows with covariance `I + J C J'`.

use nalgebra::{DMatrix, DVector};

use admire_identify::tolerance::transposed;

/// Covariance of predicted whitened rows, in factored form.
pub(super) struct PredictiveDistribution {
    /// Derivatives of the whitened rows with respect to the uncertain unknowns.
    J: DMatrix<f64>,
    /// Product `J C`, where `C` is the covariance of the unknowns.
    JC: DMatrix<f64>,
}

impl PredictiveDistribution {
    /// Creates the distribution from the derivatives of the whitened rows and the covariance of the unknowns.
    pub(super) fn new(J: DMatrix<f64>, covariance: &DMatrix<f64>) -> Self {
        Self {
            JC: &J * covariance,
            J,
        }
    }

    /// Adds further unknowns that act on the same rows and are independent of the existing unknowns.
    pub(super) fn with(self, J: &DMatrix<f64>, covariance: &DMatrix<f64>) -> Self {
        let beside = |a: &DMatrix<f64>, b: &DMatrix<f64>| {
            let mut both = a.clone().resize_horizontally(a.ncols() + b.ncols(), 0.0);
            both.columns_mut(a.ncols(), b.ncols()).copy_from(b);
            both
        };
        Self {
            JC: beside(&self.JC, &(J * covariance)),
            J: beside(&self.J, J),
        }
    }

    /// Returns the predictive variance of a whitened row.
    pub(super) fn variance(&self, row: usize) -> f64 {
        1.0 + self.J.row(row).dot(&self.JC.row(row))
    }

    /// Returns `r' (I + J C J')^-1 r = r'r - r'J (I + C J'J)^-1 C J'r` (Woodbury's formula), or `None` if the matrix is singular. The cost
    /// is linear in the number of rows.
    pub(super) fn chi_square(&self, r: &DVector<f64>) -> Option<f64> {
        let k = self.J.ncols();
        let M = transposed(&self.JC, &self.J) + DMatrix::identity(k, k);
        let step = M.lu().solve(&self.JC.tr_mul(r))?;
        Some(r.norm_squared() - self.J.tr_mul(r).dot(&step))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_study::noise::Noise;

    /// Checks the result against the inverse of the full covariance matrix.
    #[test]
    fn chi_square_and_variances_are_those_of_the_whole_covariance() {
        let mut noise = Noise::new(7, "foreseen");
        let mut drawn = |rows, columns| DMatrix::from_fn(rows, columns, |_, _| noise.normal());
        let (J, R) = (drawn(40, 6), drawn(40, 3));
        let (root, other) = (drawn(6, 6), drawn(3, 1));
        let r = drawn(40, 1).column(0).into_owned();
        // The covariance of the further unknowns is singular.
        let (C, D) = (&root * root.transpose(), &other * other.transpose());
        let S =
            &J * &C * J.transpose() + &R * &D * R.transpose() + DMatrix::<f64>::identity(40, 40);
        let found = PredictiveDistribution::new(J, &C).with(&R, &D);
        for k in 0..40 {
            assert!((found.variance(k) - S[(k, k)]).abs() < 1e-12 * S[(k, k)]);
        }
        let expected = r.dot(&(S.try_inverse().unwrap() * &r));
        let chi_square = found.chi_square(&r).unwrap();
        assert!((chi_square - expected).abs() < 1e-10 * expected);
    }
}
