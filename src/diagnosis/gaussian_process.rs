//! Gaussian process with squared exponential covariance, for a force that is a smooth function of one coordinate of the load cases.
//!
//! Source: Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), chapters 2 and 5.

use crate::priors::{GP_FORCE_SIZES, GP_LENGTH_SCALES, GP_MISFIT_LENGTH_SCALES};
use crate::settings::{GP_FACTOR_TOLERANCE, GP_ROUND_OFF};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use admire_solver::mechanics::eigen::symmetric_eigen;

/// Number of combinations of length scale and standard deviation that are tried.
pub(super) const GRID_SIZE: usize = GP_LENGTH_SCALES.len() * GP_FORCE_SIZES.len();

/// Range over which a Gaussian-process force is correlated along its coordinate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Reach {
    /// Long range: the force is smooth.
    Smooth,
    /// Short range: the force may change from one case to the next.
    Short,
}

/// Posterior of the force in all cases, at the length scale and standard deviation of largest evidence.
pub(super) struct GpPosterior {
    /// Gain in log evidence over a model without the force, in nats.
    pub nats: f64,
    /// Decrease of chi-square by the force.
    pub taken: f64,
    /// Posterior mean of the force in each case.
    pub mean: DVector<f64>,
    /// Posterior covariance of the force between all cases.
    pub covariance: DMatrix<f64>,
    /// Factor of the prior covariance: the covariance is `root` times its transpose.
    pub root: DMatrix<f64>,
}

impl GpPosterior {
    /// Fits the process, and returns its posterior at the length scale and standard deviation of largest evidence. `coordinate` holds the
    /// coordinate of each case. `information` and `gradient` are the information matrix and the score of a separate force in each case, with
    /// all other unknowns of the fit eliminated. `force` is the typical force. If `beyond_a_line`, the constant and the straight line in the
    /// coordinate are projected out. Returns `None` if the coordinate does not vary.
    pub(super) fn best(
        coordinate: &[f64],
        information: &DMatrix<f64>,
        gradient: &DVector<f64>,
        force: f64,
        reach: Reach,
        beyond_a_line: bool,
    ) -> Option<Self> {
        let n = coordinate.len();
        let low = coordinate.iter().copied().fold(f64::INFINITY, f64::min);
        let high = coordinate.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let range = high - low;
        if !(range > 0.0) {
            return None;
        }
        let mut out: Option<Self> = None;
        let lengths = match reach {
            Reach::Smooth => GP_LENGTH_SCALES,
            Reach::Short => GP_MISFIT_LENGTH_SCALES,
        };
        for length in lengths {
            let alike = |a: usize, b: usize| {
                let apart = (coordinate[a] - coordinate[b]) / (length * range);
                libm::exp(-0.5 * apart * apart)
            };
            let mut root = root_of(n, alike);
            if beyond_a_line {
                root = off_a_line(coordinate, (low, range), root);
            }
            let eigen = symmetric_eigen(root.transpose() * &root);
            let least = GP_ROUND_OFF * eigen.eigenvalues.max();
            let kept: Vec<usize> = (0..root.ncols())
                .filter(|k| eigen.eigenvalues[*k] > least)
                .collect();
            root *= eigen.eigenvectors.select_columns(&kept);
            let transposed = root.transpose();
            let (M, g) = (&transposed * (information * &root), &transposed * gradient);
            let mut best: Option<(f64, f64, DVector<f64>, Cholesky<f64, Dyn>)> = None;
            for size in GP_FORCE_SIZES {
                let s = size * force;
                let Some(factor) =
                    Cholesky::new(&M * (s * s) + DMatrix::identity(kept.len(), kept.len()))
                else {
                    continue;
                };
                let z = factor.solve(&(&g * s));
                let logs: f64 = factor
                    .l_dirty()
                    .diagonal()
                    .iter()
                    .map(|d| libm::log(*d))
                    .sum();
                let nats = 0.5 * s * g.dot(&z) - logs;
                if nats.is_finite() && best.as_ref().is_none_or(|(most, ..)| nats > *most) {
                    best = Some((nats, s, z, factor));
                }
            }
            let better =
                |(nats, ..): &(f64, _, _, _)| out.as_ref().is_none_or(|law| *nats > law.nats);
            if let Some((nats, s, z, factor)) = best.filter(better) {
                out = Some(Self {
                    nats,
                    taken: 2.0 * s * g.dot(&z) - s * s * z.dot(&(&M * &z)),
                    covariance: &root * factor.inverse() * &transposed * (s * s),
                    mean: &root * &z * s,
                    root: root * s,
                });
            }
        }
        out
    }
}

/// Returns a low-rank factor of a smooth covariance matrix with unit diagonal, by pivoted Cholesky decomposition. Each pivot is the largest
/// remaining variance. Source: Harbrecht, Peters and Schneider, Applied Numerical Mathematics 62 (2012) 428.
fn root_of(n: usize, covariance: impl Fn(usize, usize) -> f64) -> DMatrix<f64> {
    let mut left = vec![1.0; n];
    let mut columns: Vec<DVector<f64>> = Vec::new();
    while columns.len() < n {
        let pivot = (0..n).fold(0, |most, k| if left[k] > left[most] { k } else { most });
        if left[pivot] <= GP_FACTOR_TOLERANCE {
            break;
        }
        let mut column = DVector::from_fn(n, |row, _| covariance(row, pivot));
        for known in &columns {
            column.axpy(-known[pivot], known, 1.0);
        }
        column /= left[pivot].sqrt();
        for (left, value) in left.iter_mut().zip(&column) {
            *left -= value * value;
        }
        columns.push(column);
    }
    DMatrix::from_columns(&columns)
}

/// Projects the constant and the straight line in the coordinate out of each column.
fn off_a_line(coordinate: &[f64], (low, range): (f64, f64), columns: DMatrix<f64>) -> DMatrix<f64> {
    let X = DMatrix::from_fn(coordinate.len(), 2, |row, column| match column {
        0 => 1.0,
        _ => (coordinate[row] - low) / range - 0.5,
    });
    let along = X.transpose() * &columns;
    match Cholesky::new(X.tr_mul(&X)) {
        Some(factor) => columns - X * factor.solve(&along),
        None => columns,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thirty forces are measured with unit error. A sine wave over the deflection is recovered within its band; a straight line yields no
    /// evidence.
    #[test]
    fn a_wave_is_found_and_a_line_is_not() {
        let n = 30_u8;
        let u: Vec<f64> = (0..n).map(|k| f64::from(k) * 0.1).collect();
        let wave = DVector::from_fn(usize::from(n), |k, _| 20.0 * (2.5 * u[k]).sin());
        let information = DMatrix::identity(usize::from(n), usize::from(n));
        // Readings equal forces here, so the gradient is the reading itself.
        let found = GpPosterior::best(&u, &information, &wave, 100.0, Reach::Smooth, true);
        let GpPosterior {
            nats,
            taken,
            mean,
            covariance,
            root,
            ..
        } = found.unwrap();
        assert!(nats > 100.0, "{nats}");
        assert!(taken > 0.0);
        assert_eq!(root.nrows(), usize::from(n));
        let beyond = off_a_line(
            &u,
            (0.0, 2.9),
            DMatrix::from_columns(std::slice::from_ref(&wave)),
        );
        for k in 0..usize::from(n) {
            assert!(
                (mean[k] - beyond[k]).abs() < 4.0 * covariance[(k, k)].sqrt(),
                "{k}"
            );
        }
        let covariance = |a: usize, b: usize| (-2.0 * (u[a] - u[b]).powi(2)).exp();
        let factor = root_of(usize::from(n), covariance);
        assert!(factor.ncols() < 20, "{}", factor.ncols());
        let off = &factor * factor.transpose()
            - DMatrix::from_fn(usize::from(n), usize::from(n), covariance);
        assert!(off.amax() < 1e-8, "{:e}", off.amax());
        let line = DVector::from_fn(usize::from(n), |k, _| 7.0 + 20.0 * u[k]);
        let found = GpPosterior::best(&u, &information, &line, 100.0, Reach::Smooth, true);
        assert!(found.unwrap().nats < 1.0);
    }
}
