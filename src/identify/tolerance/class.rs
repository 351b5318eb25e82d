//! Variance classes of whitened rows, and blocks of rows that the whitening transforms together.

use crate::settings::EQUAL_VARIANCE_RATIO;
use std::sync::Arc;

use nalgebra::DMatrix;

/// Variance shared by a class of rows: a weighted sum of squared standard deviations of reading noise and of rigid-motion noise of marks.
#[derive(Clone, PartialEq, Debug)]
pub struct VarianceClass {
    /// Known part of the variance: 1 if the noise of the readings is known, and 0 if it is estimated.
    pub known: f64,
    /// Estimated parts of the variance. Each consists of an index into [`VarianceComponents::ln`](super::group::VarianceComponents::ln) and the
    /// coefficient of that squared standard deviation.
    pub terms: Arc<[(usize, f64)]>,
}

impl VarianceClass {
    /// Creates the variance class of a row. `scale` is the index of its noise scale if the noise is estimated. For a rigid-motion direction of
    /// marks, `rigid` holds the index of its variance component and the squared norm of the direction.
    pub(super) fn new(scale: Option<usize>, rigid: Option<(usize, f64)>) -> Self {
        let own = scale.map(|at| (at, 1.0));
        Self {
            known: if scale.is_some() { 0.0 } else { 1.0 },
            terms: own.into_iter().chain(rigid).collect(),
        }
    }

    /// Returns the variance of the rows, given the logarithms `ln` of all standard deviations.
    pub(crate) fn variance(&self, ln: &[f64]) -> f64 {
        let terms = self.terms.iter();
        terms.fold(self.known, |sum, (at, mu)| {
            sum + mu * libm::exp(2.0 * ln[*at])
        })
    }

    /// Returns the derivatives of the variance with respect to the log standard deviations, as pairs of index and derivative. Derivatives that
    /// are zero are omitted.
    pub(crate) fn by_size(&self, ln: &[f64]) -> Vec<(usize, f64)> {
        let terms = self.terms.iter();
        terms
            .map(|(at, mu)| (*at, 2.0 * mu * libm::exp(2.0 * ln[*at])))
            .collect()
    }

    /// Returns a key that is equal for classes whose coefficients differ by less than about a factor of [`EQUAL_VARIANCE_RATIO`].
    pub(super) fn key(&self) -> (u64, Vec<(usize, i64)>) {
        let bin = |mu: f64| (libm::log(mu) / libm::log(EQUAL_VARIANCE_RATIO)).round() as i64;
        let terms = self.terms.iter().map(|(at, mu)| (*at, bin(*mu)));
        (self.known.to_bits(), terms.collect())
    }
}

/// Rows that the whitening transforms together by an orthonormal change of directions.
pub(super) struct RotatedBlock {
    /// Indices of the rows of this block among all rows.
    pub places: Vec<usize>,
    /// Transformation matrix with one row per transformed row; its columns are scaled by the square roots of the precisions. Rigid-motion
    /// directions come first.
    pub matrix: DMatrix<f64>,
    /// Number of leading rows of `matrix` that are rigid-motion directions.
    pub rigid: usize,
    /// Variance class of each transformed row; `None` if the row is not used.
    pub classes: Vec<Option<VarianceClass>>,
}
