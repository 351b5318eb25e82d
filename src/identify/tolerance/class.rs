//! Rows that whitening turns together, and classes of rows of one variance.

use std::sync::Arc;

use nalgebra::DMatrix;

/// Classes whose terms differ by less than this factor are one.
const ALIKE: f64 = 1.05;

/// Rows whose variance is a sum of squares of sizes: of the noise of a reading, of the rigid motion of marks.
#[derive(Clone, PartialEq, Debug)]
pub struct VarianceClass {
    /// What is there whatever the sizes are: one where the noise is known.
    pub known: f64,
    /// Sizes by their places, and how much of the square of each is in the variance.
    pub terms: Arc<[(usize, f64)]>,
}

impl VarianceClass {
    /// Of noise with a scale, or of one without, and of a rigid motion with its size and the square of its direction.
    pub(super) fn new(scale: Option<usize>, rigid: Option<(usize, f64)>) -> Self {
        let own = scale.map(|at| (at, 1.0));
        Self {
            known: if scale.is_some() { 0.0 } else { 1.0 },
            terms: own.into_iter().chain(rigid).collect(),
        }
    }

    /// Variance at these sizes.
    pub(crate) fn variance(&self, ln: &[f64]) -> f64 {
        let terms = self.terms.iter();
        terms.fold(self.known, |sum, (at, mu)| {
            sum + mu * libm::exp(2.0 * ln[*at])
        })
    }

    /// Its derivatives by the logarithms of the sizes.
    pub(crate) fn by_size(&self, ln: &[f64]) -> Vec<(usize, f64)> {
        let terms = self.terms.iter();
        terms
            .map(|(at, mu)| (*at, 2.0 * mu * libm::exp(2.0 * ln[*at])))
            .collect()
    }

    /// What classes have in common whose variances differ by less than a factor [`ALIKE`].
    pub(super) fn key(&self) -> (u64, Vec<(usize, i64)>) {
        let bin = |mu: f64| (libm::log(mu) / libm::log(ALIKE)).round() as i64;
        let terms = self.terms.iter().map(|(at, mu)| (*at, bin(*mu)));
        (self.known.to_bits(), terms.collect())
    }
}

/// Rows that are turned together.
pub(super) struct Turned {
    /// Where they are among all rows.
    pub places: Vec<usize>,
    /// One row per new direction, times the root of the precision; those that rigid motions lead along come first.
    pub matrix: DMatrix<f64>,
    /// How many these are.
    pub rigid: usize,
    /// Of each new row; `None` where it is not used.
    pub classes: Vec<Option<VarianceClass>>,
}
