use nalgebra::{Cholesky, DMatrix};

use super::normal;

/// Group of correlated parameters (Gaussian copula): their normal scores have given correlations, and each parameter keeps its own
/// distribution.
#[derive(Clone, PartialEq, Debug)]
pub struct Correlation {
    members: Vec<usize>,
    /// Lower Cholesky factor L of the correlation matrix L L'.
    lower: DMatrix<f64>,
}

impl Correlation {
    /// Creates a group from the indices of its members among the variations. `None` if the matrix is not positive definite, and therefore not a
    /// correlation matrix.
    pub(crate) fn new(members: Vec<usize>, matrix: &DMatrix<f64>) -> Option<Self> {
        let lower = Cholesky::new(matrix.clone())?.unpack();
        Some(Self { members, lower })
    }

    /// Transforms independent probabilities of all parameters into correlated probabilities, in place.
    pub(crate) fn apply(&self, unit: &mut [f64]) {
        let scores: Vec<f64> = self
            .members
            .iter()
            .map(|&at| normal::quantile(unit[at]))
            .collect();
        // The first member of the group remains unchanged, to the last bit.
        for (row, &at) in self.members.iter().enumerate().skip(1) {
            let score: f64 = (0..=row).map(|k| self.lower[(row, k)] * scores[k]).sum();
            unit[at] =
                normal::probability(score).clamp(f64::MIN_POSITIVE, 1.0 - f64::EPSILON / 2.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Stream;
    use super::*;

    #[test]
    fn normal_scores_have_the_correlation_asked_for() {
        let matrix = DMatrix::from_row_slice(2, 2, &[1.0, -0.6, -0.6, 1.0]);
        let group = Correlation::new(vec![2, 0], &matrix).unwrap();
        let streams = [
            Stream::named(1, "a"),
            Stream::named(1, "b"),
            Stream::named(1, "c"),
        ];
        let count = 20_000;
        let mut sums = [0.0; 5];
        for case in 0..count {
            let mut unit: Vec<f64> = streams.iter().map(|s| s.uniform(case)).collect();
            let untouched = unit[1];
            group.apply(&mut unit);
            assert_eq!(unit[1], untouched);
            let (x, y) = (normal::quantile(unit[2]), normal::quantile(unit[0]));
            for (sum, term) in sums.iter_mut().zip([x, y, x * x, y * y, x * y]) {
                *sum += term / count as f64;
            }
        }
        let [x, y, xx, yy, xy] = sums;
        let r = (xy - x * y) / ((xx - x * x) * (yy - y * y)).sqrt();
        // Standard error of r: (1 - r^2)/sqrt(n) = 0.0045.
        assert!((r + 0.6).abs() < 0.018, "{r}");
        assert!(x.abs() < 0.03 && (yy - 1.0).abs() < 0.04);
    }

    #[test]
    fn impossible_correlations_are_none() {
        let matrix = DMatrix::from_fn(3, 3, |i, j| if i == j { 1.0 } else { -0.9 });
        assert!(Correlation::new(vec![0, 1, 2], &matrix).is_none());
    }
}
