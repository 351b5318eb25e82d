//! Least squares with lower and upper bounds, from normal equations.

use nalgebra::{DMatrix, DVector};

/// The minimum of `x^T A x / 2 - b^T x` with `lower <= x <= upper`, and which unknowns are at a bound.
///
/// `a` is symmetric and positive semidefinite. Active-set method of Lawson and Hanson, with upper bounds. Directions nothing
/// determines stay at the least norm in the scale of the diagonal of `a`.
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
    let mut fixed: Vec<Option<f64>> = vec![None; count];
    let mut x = DVector::zeros(count);
    // Each round fixes or releases at least one unknown; twice the count is more than cycling-free problems need.
    for _ in 0..2 * count + 10 {
        x = free_solution(a, b, &fixed, &scale);
        let beyond = (0..count)
            .filter(|&k| fixed[k].is_none())
            .map(|k| (k, (lower[k] - x[k]).max(x[k] - upper[k]) * scale[k]))
            .filter(|(_, by)| *by > 1e-9)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((worst, _)) = beyond {
            fixed[worst] = Some(x[worst].clamp(lower[worst], upper[worst]));
            continue;
        }
        // A bound holds only while the gradient pushes against it.
        let gradient = a * &x - b;
        let release = (0..count)
            .filter_map(|k| {
                let at = fixed[k]?;
                let push = if at <= lower[k] {
                    -gradient[k]
                } else {
                    gradient[k]
                } / scale[k];
                (push > 1e-9).then_some((k, push))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1));
        match release {
            Some((k, _)) => fixed[k] = None,
            None => break,
        }
    }
    (x, fixed.iter().map(Option::is_some).collect())
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
    let eigen = a.symmetric_eigen();
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

    #[test]
    fn a_bound_that_binds_and_one_that_does_not() {
        // (x - 1)^2 + (y + 1)^2 + x y with x, y >= 0: y is at its bound, then x = 1.
        let a = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
        let b = DVector::from_vec(vec![2.0, -2.0]);
        let (x, fixed) = solve(&a, &b, &[0.0, 0.0], &[10.0, 10.0]);
        assert!((x[0] - 1.0).abs() < 1e-12 && x[1] == 0.0);
        assert_eq!(fixed, [false, true]);
        let (x, fixed) = solve(&a, &b, &[-10.0, -10.0], &[10.0, 10.0]);
        assert!((a * x - b).norm() < 1e-12);
        assert_eq!(fixed, [false, false]);
    }
}
