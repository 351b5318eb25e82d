//! Variance classes of rows, and blocks of rows that whitening transforms together.

use crate::settings::EQUAL_VARIANCE_RATIO;
use std::sync::Arc;

use nalgebra::DMatrix;

/// Class of rows with equal variance: a weighted sum of the squared standard deviations of reading noise and of rigid-motion noise of marks.
#[derive(Clone, PartialEq, Debug)]
pub struct VarianceClass {
    /// Part of the variance that depends on no variance component: 1 where the reading noise is known, else 0.
    pub known: f64,
    /// Estimated components of the variance: index into [`VarianceComponents::ln`](super::group::VarianceComponents::ln), and coefficient of
    /// the squared standard deviation.
    pub terms: Arc<[(usize, f64)]>,
}

impl VarianceClass {
    /// Creates the class of a row. `scale` is the index of its noise scale, if that is estimated. `rigid` is the index of its rigid-motion
    /// component and the squared norm of the rigid direction.
    pub(super) fn new(scale: Option<usize>, rigid: Option<(usize, f64)>) -> Self {
        let own = scale.map(|at| (at, 1.0));
        Self {
            known: if scale.is_some() { 0.0 } else { 1.0 },
            terms: own.into_iter().chain(rigid).collect(),
        }
    }

    /// Returns the variance, given the log standard deviations `ln`.
    pub(crate) fn variance(&self, ln: &[f64]) -> f64 {
        let terms = self.terms.iter();
        terms.fold(self.known, |sum, (at, mu)| {
            sum + mu * libm::exp(2.0 * ln[*at])
        })
    }

    /// Returns the derivatives of the variance with respect to the log standard deviations, as pairs of index and derivative.
    pub(crate) fn by_size(&self, ln: &[f64]) -> Vec<(usize, f64)> {
        let terms = self.terms.iter();
        terms
            .map(|(at, mu)| (*at, 2.0 * mu * libm::exp(2.0 * ln[*at])))
            .collect()
    }

    /// Returns a key shared by classes whose coefficients agree to about a factor of [`EQUAL_VARIANCE_RATIO`].
    pub(super) fn key(&self) -> (u64, Vec<(usize, i64)>) {
        let bin = |mu: f64| (libm::log(mu) / libm::log(EQUAL_VARIANCE_RATIO)).round() as i64;
        let terms = self.terms.iter().map(|(at, mu)| (*at, bin(*mu)));
        (self.known.to_bits(), terms.collect())
    }
}

/// Rows of readings that are rotated together.
pub(super) struct RotatedBlock {
    /// Indices of the rows among all rows.
    pub places: Vec<usize>,
    /// Transformation matrix: one row per new direction, scaled by the square root of the precision. Rigid-motion directions come first.
    pub matrix: DMatrix<f64>,
    /// Number of rigid-motion directions.
    pub rigid: usize,
    /// Variance class of each new row; `None` where the row is not used.
    pub classes: Vec<Option<VarianceClass>>,
}
