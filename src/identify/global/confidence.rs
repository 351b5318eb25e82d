//! How well the unknowns of a fit are known: covariance, intervals, what the data cannot tell apart.

use nalgebra::{DMatrix, SymmetricEigen};

use super::gauss_newton::{LeastSquares, Minimum, Prior, Tolerances, minimise};

/// Half the 95 percent point of chi-square with one degree of freedom: 3.841 / 2.
const HALF_CHI2_95: f64 = 1.920_729;
/// 97.5 percent point of the normal distribution.
pub const NORMAL_975: f64 = 1.959_964;
/// A side of an interval that reaches further than this from the estimate, in e-folds, has no bound.
const UNBOUNDED: f64 = 7.0;

/// Posterior covariance of all unknowns: the inverse of data plus prior information. Zero for held ones.
pub fn covariance(minimum: &Minimum, held: &[bool]) -> DMatrix<f64> {
    let mut information = minimum.information.clone();
    for (k, held) in held.iter().enumerate() {
        if *held {
            information.fill_row(k, 0.0);
            information.fill_column(k, 0.0);
            information[(k, k)] = 1.0;
        }
    }
    let mut covariance = invert(&information);
    for (k, held) in held.iter().enumerate() {
        if *held {
            covariance.fill_row(k, 0.0);
            covariance.fill_column(k, 0.0);
        }
    }
    covariance
}

/// Inverse of a positive matrix; directions without any information get a variance that says so.
fn invert(information: &DMatrix<f64>) -> DMatrix<f64> {
    let mut jitter = 0.0;
    loop {
        let mut lifted = information.clone();
        for k in 0..lifted.nrows() {
            lifted[(k, k)] += jitter * information[(k, k)].max(f64::MIN_POSITIVE);
        }
        if let Some(factor) = nalgebra::Cholesky::new(lifted) {
            return factor.inverse();
        }
        jitter = if jitter == 0.0 { 1e-15 } else { jitter * 10.0 };
        if jitter > 1.0 {
            return DMatrix::identity(information.nrows(), information.ncols()) * f64::MAX.sqrt();
        }
    }
}

/// A combination of unknowns that the data leave open.
#[derive(Clone, PartialEq, Debug)]
pub struct OpenDirection {
    /// Weight of each unknown that takes part noticeably, largest first; the squares of all weights sum to one.
    pub weights: Vec<(usize, f64)>,
    /// Standard deviation along it.
    pub sd: f64,
}

/// Eigenvectors of the covariance of the first `count` unknowns whose standard deviation exceeds `limit`, worst first.
pub fn open_directions(covariance: &DMatrix<f64>, count: usize, limit: f64) -> Vec<OpenDirection> {
    if count == 0 {
        return Vec::new();
    }
    let eigen = SymmetricEigen::new(covariance.view((0, 0), (count, count)).into_owned());
    let mut found: Vec<OpenDirection> = (0..count)
        .filter_map(|k| {
            let sd = eigen.eigenvalues[k].max(0.0).sqrt();
            if sd <= limit {
                return None;
            }
            let mut weights: Vec<(usize, f64)> = eigen
                .eigenvectors
                .column(k)
                .iter()
                .copied()
                .enumerate()
                .filter(|(_, w)| w.abs() > 0.15)
                .collect();
            weights.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            if weights.first().is_some_and(|(_, w)| *w < 0.0) {
                for (_, weight) in &mut weights {
                    *weight = -*weight;
                }
            }
            Some(OpenDirection { weights, sd })
        })
        .collect();
    found.sort_by(|a, b| b.sd.total_cmp(&a.sd));
    found
}

/// 95 percent interval of unknown `k` by profile likelihood: where the objective, minimised over all others, has risen by 1.92.
///
/// The prior of `k` itself is left out, so that a side the data do not bound is `None`. Each side costs a few constrained fits.
pub fn profile_interval(
    problem: &mut dyn LeastSquares,
    minimum: &Minimum,
    (k, sd): (usize, f64),
    priors: &[Prior],
    scale: &[f64],
    held: &[bool],
) -> [Option<f64>; 2] {
    let mut priors = priors.to_vec();
    priors[k].sd = f64::INFINITY;
    let mut held = held.to_vec();
    held[k] = true;
    let tolerances = Tolerances {
        decrement: 1e-3,
        step: 1e-6,
        max_iterations: 12,
    };
    let mut base = minimum.objective;
    let mut side = |direction: f64| {
        let mut inner = minimum.x[k];
        let mut rise_inner = 0.0;
        let mut start = minimum.x.clone();
        let mut reach = (NORMAL_975 * sd).min(2.0);
        for _ in 0..12 {
            let at = inner + direction * reach;
            if (at - minimum.x[k]).abs() > UNBOUNDED {
                return None;
            }
            start[k] = at;
            let Some(found) = minimise(problem, &start, &priors, scale, &held, tolerances) else {
                reach *= 0.5;
                continue;
            };
            // The estimate is the minimum with the prior of k; without it the others may do a little better.
            base = base.min(found.objective);
            let rise = found.objective - base;
            start.clone_from(&found.x);
            if (rise - HALF_CHI2_95).abs() < 0.04 {
                return Some(at);
            }
            if rise < HALF_CHI2_95 {
                (inner, rise_inner) = (at, rise);
                // The rise grows about as the square of the distance.
                let distance = (inner - minimum.x[k]).abs();
                let ratio = (HALF_CHI2_95 / rise_inner.max(0.02)).sqrt().min(3.0);
                reach = (distance * (ratio - 1.0)).max(0.02 * distance);
            } else {
                let share =
                    (HALF_CHI2_95.sqrt() - rise_inner.sqrt()) / (rise.sqrt() - rise_inner.sqrt());
                reach *= share.clamp(0.1, 0.95);
            }
        }
        Some(inner + direction * reach)
    };
    [side(-1.0), side(1.0)]
}
