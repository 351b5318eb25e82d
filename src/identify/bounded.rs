//! Bound-constrained least squares from normal equations.

use crate::settings::{MAX_ACTIVE_SET_ROUNDS, MAX_BLOCK_EXCHANGES};
use nalgebra::{DMatrix, DVector};

use admire_solver::mechanics::eigen::symmetric_eigen;

/// Minimises `x^T A x / 2 - b^T x` subject to `lower <= x <= upper`. Returns the minimiser, and for each unknown whether it is at a bound.
///
/// `a` must be symmetric and positive semidefinite. The set of active bounds is found by block exchanges (Portugal, Judice and Vicente 1994).
/// If the exchanges do not terminate, an active-set method follows. If the unknowns away from their bounds are not determined uniquely, they
/// get the solution of least norm, scaled by the diagonal of `a`.
pub(super) fn solve(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    lower: &[f64],
    upper: &[f64],
) -> (DVector<f64>, Vec<bool>) {
    let count = b.len();
    let scale: Vec<f64> = (0..count)
        .map(|k| a[(k, k)].max(f64::MIN_POSITIVE).sqrt())
        .collect();
    let size = (0..count)
        .map(|k| (b[k] / scale[k]).abs())
        .fold(0.0, f64::max);
    let problem = BoundedProblem {
        a,
        b,
        bounds: (lower, upper),
        tolerance: (1e-10 * size).max(1e-12),
        scale,
    };
    let (x, fixed) = problem.exchanged().unwrap_or_else(|| problem.descended());
    let inside = DVector::from_fn(count, |k, _| x[k].clamp(lower[k], upper[k]));
    (inside, fixed.iter().map(Option::is_some).collect())
}

struct BoundedProblem<'a> {
    a: &'a DMatrix<f64>,
    b: &'a DVector<f64>,
    bounds: (&'a [f64], &'a [f64]),
    tolerance: f64,
    scale: Vec<f64>,
}

impl BoundedProblem<'_> {
    /// Finds the minimum by block exchanges. Each round fixes all unknowns that are outside their bounds and releases all fixed unknowns whose
    /// multiplier has the wrong sign. A few rounds are usually enough. Returns `None` if the set of fixed unknowns still changes after
    /// [`MAX_BLOCK_EXCHANGES`] rounds.
    fn exchanged(&self) -> Option<(DVector<f64>, Vec<Option<f64>>)> {
        let (lower, upper) = self.bounds;
        let mut fixed: Vec<Option<f64>> = vec![None; self.b.len()];
        for _ in 0..MAX_BLOCK_EXCHANGES {
            let x = free_solution(self.a, self.b, &fixed, &self.scale);
            let gradient = self.a * &x - self.b;
            let mut done = true;
            for k in 0..fixed.len() {
                let next = match fixed[k] {
                    None => {
                        let beyond = (lower[k] - x[k]).max(x[k] - upper[k]);
                        (beyond * self.scale[k] > self.tolerance)
                            .then(|| x[k].clamp(lower[k], upper[k]))
                    }
                    Some(at) => (!self.pulls_inside(k, at, gradient[k])).then_some(at),
                };
                done &= next.is_some() == fixed[k].is_some();
                fixed[k] = next;
            }
            if done {
                return Some((x, fixed));
            }
        }
        None
    }

    /// Returns true if descent moves unknown `k` from its bound into the interior, so that the bound must be released.
    fn pulls_inside(&self, k: usize, at: f64, gradient: f64) -> bool {
        let outward = if at <= self.bounds.0[k] {
            gradient
        } else {
            -gradient
        };
        outward / self.scale[k] < -self.tolerance
    }

    /// Finds the minimum by an active-set method with Newton steps in the free unknowns. Each Newton step gives two trial points: the full step
    /// projected onto the bounds, and the step cut off at the first bound. The better trial point is taken. If neither lowers the objective,
    /// only the bound whose multiplier is most wrong is released.
    fn descended(&self) -> (DVector<f64>, Vec<Option<f64>>) {
        let (lower, upper) = self.bounds;
        let count = self.b.len();
        let project =
            |x: &DVector<f64>| DVector::from_fn(count, |k, _| x[k].clamp(lower[k], upper[k]));
        let value = |x: &DVector<f64>| 0.5 * x.dot(&(self.a * x)) - x.dot(self.b);
        let mut x = project(&DVector::zeros(count));
        let mut best = value(&x);
        let mut fixed = vec![None; count];
        let mut one_at_a_time = false;
        for _ in 0..MAX_ACTIVE_SET_ROUNDS {
            let gradient = self.a * &x - self.b;
            let wrong: Vec<usize> = (0..count)
                .filter(|&k| x[k] <= lower[k] || x[k] >= upper[k])
                .filter(|&k| self.pulls_inside(k, x[k], gradient[k]))
                .collect();
            let pull = |k: &usize| (gradient[*k] / self.scale[*k]).abs();
            let worst = wrong
                .iter()
                .copied()
                .max_by(|a, b| pull(a).total_cmp(&pull(b)));
            for (k, fixed) in fixed.iter_mut().enumerate() {
                let at_bound = x[k] <= lower[k] || x[k] >= upper[k];
                let released = if one_at_a_time {
                    worst == Some(k)
                } else {
                    wrong.contains(&k)
                };
                *fixed = (at_bound && !released).then_some(x[k]);
            }
            // If the step would move a free unknown from its bound outwards, the unknown is fixed again and the step is recomputed.
            let step = loop {
                let step = free_solution(self.a, self.b, &fixed, &self.scale) - &x;
                let leaves = |k: usize| {
                    (x[k] <= lower[k] && step[k] < 0.0) || (x[k] >= upper[k] && step[k] > 0.0)
                };
                let mut kept = false;
                for k in 0..count {
                    if fixed[k].is_none() && leaves(k) {
                        fixed[k] = Some(x[k]);
                        kept = true;
                    }
                }
                if !kept {
                    break step;
                }
            };
            // Fraction of the step that reaches the bound of each unknown, and the smallest of these fractions, at most 1.
            let room = |k: usize| {
                let bound = if step[k] < 0.0 { lower[k] } else { upper[k] };
                if step[k] == 0.0 {
                    f64::INFINITY
                } else {
                    (bound - x[k]) / step[k]
                }
            };
            let first = (0..count)
                .filter(|&k| fixed[k].is_none())
                .map(room)
                .fold(1.0, f64::min);
            let along = DVector::from_fn(count, |k, _| {
                if room(k) <= first {
                    if step[k] < 0.0 { lower[k] } else { upper[k] }
                } else {
                    x[k] + first * step[k]
                }
            });
            let next = [project(&(&x + &step)), project(&along)]
                .into_iter()
                .map(|next| (value(&next), next))
                .filter(|(value, _)| *value < best - 1e-12 * best.abs())
                .min_by(|a, b| a.0.total_cmp(&b.0));
            match next {
                Some((lower, next)) => {
                    (best, x) = (lower, next);
                    one_at_a_time = false;
                }
                None if one_at_a_time || worst.is_none() => break,
                None => one_at_a_time = true,
            }
        }
        (x, fixed)
    }
}

fn free_solution(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    fixed: &[Option<f64>],
    scale: &[f64],
) -> DVector<f64> {
    let free: Vec<usize> = (0..b.len()).filter(|&k| fixed[k].is_none()).collect();
    let mut x = DVector::from_iterator(b.len(), fixed.iter().map(|at| at.unwrap_or(0.0)));
    let rest = b - a * &x;
    let small = DMatrix::from_fn(free.len(), free.len(), |i, j| {
        a[(free[i], free[j])] / (scale[free[i]] * scale[free[j]])
    });
    let right = DVector::from_fn(free.len(), |i, _| rest[free[i]] / scale[free[i]]);
    let solution = match small.clone().cholesky() {
        Some(factor) => factor.solve(&right),
        None => pseudo_solve(small, &right),
    };
    for (i, &k) in free.iter().enumerate() {
        x[k] = solution[i] / scale[k];
    }
    x
}

fn pseudo_solve(a: DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let eigen = symmetric_eigen(a);
    let largest = eigen.eigenvalues.max();
    let mut y = eigen.eigenvectors.transpose() * b;
    for (value, eigenvalue) in y.iter_mut().zip(eigen.eigenvalues.iter()) {
        *value = if *eigenvalue > 1e-13 * largest {
            *value / eigenvalue
        } else {
            0.0
        };
    }
    eigen.eigenvectors * y
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_study::noise::Noise;

    #[test]
    fn a_bound_that_binds_and_one_that_does_not() {
        // Minimises (x - 1)^2 + (y + 1)^2 + x y with x, y >= 0. The minimum has y at its bound, hence x = 1.
        let a = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
        let b = DVector::from_vec(vec![2.0, -2.0]);
        let (x, fixed) = solve(&a, &b, &[0.0, 0.0], &[10.0, 10.0]);
        assert!((x[0] - 1.0).abs() < 1e-12 && x[1] == 0.0);
        assert_eq!(fixed, [false, true]);
        let (x, fixed) = solve(&a, &b, &[-10.0, -10.0], &[10.0, 10.0]);
        assert!((a * x - b).norm() < 1e-12);
        assert_eq!(fixed, [false, false]);
    }

    /// Includes ill-conditioned problems on which the block exchanges cycle. The result must satisfy the Karush-Kuhn-Tucker conditions of a
    /// minimum.
    #[test]
    fn ill_conditioned_problems_end_at_their_minimum() {
        let mut noise = Noise::new(7, "bounded");
        for trial in 0..60 {
            let count = 5 + trial % 30;
            let rows = DMatrix::from_fn(count + 3, count, |_, column| {
                noise.normal() * 10f64.powi((column % 4) as i32)
            });
            let nearly = rows.column(0) + rows.column(1) * 1e-4;
            let mut rows = rows.clone();
            rows.set_column(count - 1, &nearly);
            let a = rows.tr_mul(&rows);
            let b = rows.tr_mul(&DVector::from_fn(count + 3, |_, _| 1e3 * noise.normal()));
            let (lower, upper) = (vec![-0.7; count], vec![0.4; count]);
            let (x, _) = solve(&a, &b, &lower, &upper);
            let gradient = &a * &x - &b;
            for k in 0..count {
                let force = gradient[k] / a[(k, k)].sqrt();
                assert!(x[k] >= lower[k] && x[k] <= upper[k]);
                let small = 1e-6 * b.amax() / a[(k, k)].sqrt();
                assert!(x[k] > lower[k] || force > -small, "{trial} {k}: {force}");
                assert!(x[k] < upper[k] || force < small, "{trial} {k}: {force}");
                let inside = x[k] > lower[k] && x[k] < upper[k];
                assert!(!inside || force.abs() < small, "{trial} {k}: {force}");
            }
        }
    }
}
