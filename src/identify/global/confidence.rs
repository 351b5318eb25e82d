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

/// How near to the 95 percent point a rise of the objective must be for the interval to be read off from it.
const NEAR: f64 = 0.15;
/// Points of a profile on one side.
const POINTS: usize = 10;

/// 95 percent interval of unknown `k` by profile likelihood: where the objective, minimised over all others, has risen by 1.92.
///
/// The prior of `k` itself is left out, so that a side the data do not bound is `None`. Each point starts from the farthest one that
/// lies inside, moved as the covariance expects; the last gain of its fit is predicted, not made: most cost one or two evaluations.
/// Near the end it is made from the estimate itself, too, and the lower of both counts: there may be several ways to give way.
/// Between points the square root of the rise is taken as linear.
pub fn profile_interval(
    problem: &mut dyn LeastSquares,
    minimum: &Minimum,
    (k, covariance): (usize, &DMatrix<f64>),
    priors: &[Prior],
    scale: &[f64],
    held: &[bool],
) -> [Option<f64>; 2] {
    let variance = covariance[(k, k)];
    if !(variance > 0.0) {
        return [Some(minimum.x[k]); 2];
    }
    let along: Vec<f64> = (0..minimum.x.len())
        .map(|j| covariance[(j, k)] / variance)
        .collect();
    let mut base = minimum.objective - priors[k].cost(minimum.x[k]);
    let mut priors = priors.to_vec();
    priors[k].sd = f64::INFINITY;
    let mut held = held.to_vec();
    held[k] = true;
    let tolerances = Tolerances {
        decrement: 0.05,
        step: 1e-4,
        max_iterations: 25,
    };
    let mut side = |direction: f64| {
        // Distance and square root of the rise: the last point inside, the first outside.
        let (mut inner, mut outer) = ((0.0, 0.0), None);
        let mut from = minimum.x.clone();
        let mut reach = (NORMAL_975 * variance.sqrt()).min(2.5);
        let target = HALF_CHI2_95.sqrt();
        let between = |inner: (f64, f64), outer: (f64, f64)| {
            let share = (target - inner.1) / (outer.1 - inner.1);
            inner.0 + share * (outer.0 - inner.0)
        };
        for _ in 0..POINTS {
            let step = direction * (reach - inner.0);
            let start: Vec<f64> = from
                .iter()
                .zip(&along)
                .zip(scale)
                .map(|((x, slope), scale)| x + (slope * step).clamp(-3.0 * scale, 3.0 * scale))
                .enumerate()
                .map(|(j, x)| {
                    if j == k {
                        minimum.x[k] + direction * reach
                    } else {
                        x
                    }
                })
                .collect();
            let mut found = minimise(problem, &start, &priors, scale, &held, tolerances);
            if found
                .as_ref()
                .is_none_or(|found| found.objective - found.decrement - base > HALF_CHI2_95 - NEAR)
            {
                // The others may do better from where they are at the estimate than from where the path has led them.
                let mut start = minimum.x.clone();
                start[k] += direction * reach;
                let other = minimise(problem, &start, &priors, scale, &held, tolerances);
                let lower = |found: &Option<Minimum>| {
                    found
                        .as_ref()
                        .map_or(f64::INFINITY, |found| found.objective)
                };
                if lower(&other) < lower(&found) {
                    found = other;
                }
            }
            let rise = found
                .as_ref()
                .map(|found| found.objective - found.decrement)
                .inspect(|value| base = base.min(*value))
                .map(|value| (value - base).max(0.0).sqrt());
            match rise {
                Some(rise) if rise < target => {
                    if reach >= UNBOUNDED {
                        return None;
                    }
                    inner = (reach, rise);
                    from = found.map_or(from, |found| found.x);
                }
                Some(rise) => outer = Some((reach, rise)),
                // Where the model has no answer the interval has surely ended.
                None => outer = Some((reach, 3.0 * target)),
            }
            let near = rise.is_some_and(|rise| (rise * rise - HALF_CHI2_95).abs() < NEAR);
            reach = match outer {
                // From a point this near the line through the minimum leads to the end.
                None if near => return Some(minimum.x[k] + direction * reach * target / inner.1),
                None => (reach * (target / inner.1.max(0.1)).clamp(1.15, 3.0)).min(UNBOUNDED),
                Some(outer) => {
                    let next = between(inner, outer);
                    if near || outer.0 - inner.0 < 0.05 * outer.0 {
                        return Some(minimum.x[k] + direction * next);
                    }
                    // A wall outside draws the straight line to the inner point: the bracket shrinks by a quarter at least.
                    next.max(inner.0 + 0.25 * (outer.0 - inner.0))
                }
            };
        }
        Some(minimum.x[k] + direction * reach)
    };
    [side(-1.0), side(1.0)]
}
