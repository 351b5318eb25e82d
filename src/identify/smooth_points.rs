//! Smooth changes of the points of a SPLINE along x.

use crate::settings::SMALLEST_SMOOTH_SHARE;

/// Changes of all points of a curve by one unknown. The unknown belongs to one of the points and changes it by its own value.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct SmoothChange {
    /// Index of the point to which the unknown belongs. The unknown takes the name of this point.
    pub point: usize,
    /// Change of each point per unit of the unknown.
    pub factors: Vec<f64>,
    /// Standard deviation of the unknown, as a fraction of the standard deviation of each point.
    pub share: f64,
}

/// Returns unknowns that represent a smooth Gaussian process at the points `x`. With independent normal priors of the unknowns, all points
/// have equal standard deviations. The correlation of two points is `exp(-(x_i - x_j)^2 / (2 length^2))`.
///
/// The first unknown is the change at one point, with the correlated change of all other points. Each further unknown belongs to the point
/// with the largest remaining variance, given the previous unknowns. Points with a negligible remaining variance get no unknown.
///
/// Source: pivoted Cholesky decomposition (Harbrecht, Peters and Schneider, Appl. Numer. Math. 62, 2012) of the covariance (Rasmussen and
/// Williams, Gaussian Processes for Machine Learning, equation 4.9).
pub(crate) fn smooth_changes(x: &[f64], length: f64) -> Vec<SmoothChange> {
    let covariance = |i: usize, j: usize| {
        let apart = (x[i] - x[j]) / length;
        libm::exp(-0.5 * apart * apart)
    };
    let mut rest = vec![1.0; x.len()];
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut all = Vec::new();
    while all.len() < x.len() {
        let mut points = 0..x.len();
        let Some(first) = points.next() else { break };
        let point = points.fold(first, |a, b| if rest[b] > rest[a] { b } else { a });
        let share = f64::sqrt(f64::max(rest[point], 0.0));
        if share < SMALLEST_SMOOTH_SHARE {
            break;
        }
        let column: Vec<f64> = (0..x.len())
            .map(|i| {
                let known = columns.iter().map(|own| own[i] * own[point]);
                (covariance(i, point) - known.sum::<f64>()) / share
            })
            .collect();
        for (rest, own) in rest.iter_mut().zip(&column) {
            *rest -= own * own;
        }
        all.push(SmoothChange {
            point,
            factors: column.iter().map(|own| own / share).collect(),
            share,
        });
        columns.push(column);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that the unknowns reproduce the covariance of the points. The error is small although points with a negligible remaining variance
    /// have no unknown.
    #[test]
    fn the_unknowns_have_the_stated_covariance() {
        let x = [-20.0, -11.0, -5.0, 0.0, 1.0, 2.0, 9.0, 20.0];
        for length in [0.1, 3.0, 10.0, 1000.0] {
            let all = smooth_changes(&x, length);
            for i in 0..x.len() {
                for j in 0..x.len() {
                    let each = all.iter();
                    let own =
                        |of: &SmoothChange| of.share * of.share * of.factors[i] * of.factors[j];
                    let found: f64 = each.map(own).sum();
                    let apart = (x[i] - x[j]) / length;
                    let wanted = f64::exp(-0.5 * apart * apart);
                    assert!((found - wanted).abs() < 2e-6, "{length}: {i} {j}");
                }
            }
            for own in &all {
                assert!((own.factors[own.point] - 1.0).abs() < 1e-12);
            }
        }
        // Far apart, every point is by itself; close together, all are one.
        assert_eq!(smooth_changes(&x, 0.1).len(), x.len());
        let stiff = smooth_changes(&x, 1e6);
        assert_eq!(stiff.len(), 1);
        assert!(stiff[0].factors.iter().all(|own| (own - 1.0).abs() < 1e-3));
    }
}
