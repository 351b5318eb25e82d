//! Eigenvalues and singular values with a bounded number of iterations.
//!
//! nalgebra's own functions iterate without a limit and may never terminate if products of entries underflow. Here, entries smaller than the
//! round-off of the iteration are first set to zero, and the number of iterations is limited.
//!
//! The eigenvalues of unsymmetric matrices and the singular values have methods of their own here, because nalgebra's iteration for the first has
//! no exceptional shifts and never converges for a spinning top that falls, and the product of nalgebra's three factors can differ from the
//! matrix by a thousandth of its largest entry.

use nalgebra::{Complex, DMatrix, DVector, Dyn, Hessenberg, SVD, SymmetricEigen};

use super::francis;
use super::singular::singular;

/// Entries smaller than this share of the largest entry are set to zero.
const NEGLIGIBLE: f64 = f64::EPSILON * f64::EPSILON;
/// Largest number of QR steps per row of the matrix; two or three steps per row are usual.
const STEPS: usize = 100;
/// Largest number of sweeps of Jacobi's method; six to ten sweeps are usual.
const SWEEPS: usize = 100;

/// Returns all eigenvalues of a square matrix, in no particular order. Returns `None` if an entry is not finite or the iteration does not
/// converge.
pub fn eigenvalues(matrix: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    if matrix.is_empty() {
        return Some(Vec::new());
    }
    let (matrix, largest) = scaled(matrix)?;
    let values = francis::eigenvalues(Hessenberg::new(matrix).unpack_h())?;
    Some(values.into_iter().map(|value| value * largest).collect())
}

/// Returns the eigenvalues and orthonormal eigenvectors of a symmetric matrix, in no particular order. Entries that are not finite count as
/// zero.
pub fn symmetric_eigen(matrix: DMatrix<f64>) -> SymmetricEigen<f64, Dyn> {
    let n = matrix.nrows();
    let finite = matrix.map(|value| if value.is_finite() { value } else { 0.0 });
    let Some((scaled, largest)) = scaled(finite).filter(|_| n > 0) else {
        return SymmetricEigen {
            eigenvectors: DMatrix::identity(n, n),
            eigenvalues: DVector::zeros(n),
        };
    };
    let mut eigen = SymmetricEigen::try_new(scaled.clone(), f64::EPSILON, STEPS * n)
        .unwrap_or_else(|| jacobi(scaled));
    eigen.eigenvalues *= largest;
    eigen
}

/// Returns the pseudo-inverse of a matrix. Singular values up to `least` count as zero. Returns `None` if an entry is not finite or the
/// iteration does not converge.
pub fn pseudo_inverse(matrix: DMatrix<f64>, least: f64) -> Option<DMatrix<f64>> {
    if matrix.is_empty() || matrix.iter().all(|value| *value == 0.0) {
        return Some(DMatrix::zeros(matrix.ncols(), matrix.nrows()));
    }
    singular_values(matrix, true, true)?
        .pseudo_inverse(least)
        .ok()
}

/// Returns the singular values of a matrix, largest first, with the left and right singular vectors if requested. Returns `None` if the matrix
/// is empty, an entry is not finite or the iteration does not converge.
pub fn singular_values(
    matrix: DMatrix<f64>,
    left: bool,
    right: bool,
) -> Option<SVD<f64, Dyn, Dyn>> {
    if matrix.is_empty() {
        return None;
    }
    let (matrix, largest) = scaled(matrix)?;
    // A wide matrix has the factors of its transpose, with left and right exchanged.
    let wide = matrix.ncols() > matrix.nrows();
    let found = singular(if wide { matrix.transpose() } else { matrix })?;
    let (U, V) = if wide {
        (found.V, found.U)
    } else {
        (found.U, found.V)
    };
    Some(SVD {
        u: left.then_some(U),
        v_t: right.then(|| V.transpose()),
        singular_values: DVector::from_vec(found.values) * largest,
    })
}

/// Divides a matrix by the magnitude of its largest entry and sets negligible entries to zero. Returns the scaled matrix and that magnitude, or
/// `None` if an entry is not finite.
fn scaled(mut matrix: DMatrix<f64>) -> Option<(DMatrix<f64>, f64)> {
    if matrix.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let largest = matrix.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    if largest > 0.0 {
        for value in &mut matrix {
            *value /= largest;
            if value.abs() < NEGLIGIBLE {
                *value = 0.0;
            }
        }
    }
    Some((matrix, largest))
}

/// Computes the eigendecomposition of a symmetric matrix by Jacobi's method, which always converges (Golub and Van Loan, Matrix Computations,
/// 8.5).
fn jacobi(mut a: DMatrix<f64>) -> SymmetricEigen<f64, Dyn> {
    let n = a.nrows();
    let mut v = DMatrix::identity(n, n);
    for _ in 0..SWEEPS {
        let mut turned = false;
        for p in 0..n {
            for q in p + 1..n {
                if a[(p, q)].abs() <= f64::EPSILON * f64::EPSILON {
                    continue;
                }
                turned = true;
                let tau = (a[(q, q)] - a[(p, p)]) / (2.0 * a[(p, q)]);
                let t = tau.signum() / (tau.abs() + libm::hypot(tau, 1.0));
                let c = 1.0 / libm::hypot(t, 1.0);
                let s = t * c;
                for k in 0..n {
                    let (x, y) = (a[(k, p)], a[(k, q)]);
                    (a[(k, p)], a[(k, q)]) = (c * x - s * y, s * x + c * y);
                }
                for k in 0..n {
                    let (x, y) = (a[(p, k)], a[(q, k)]);
                    (a[(p, k)], a[(q, k)]) = (c * x - s * y, s * x + c * y);
                    let (x, y) = (v[(k, p)], v[(k, q)]);
                    (v[(k, p)], v[(k, q)]) = (c * x - s * y, s * x + c * y);
                }
                (a[(p, q)], a[(q, p)]) = (0.0, 0.0);
            }
        }
        if !turned {
            break;
        }
    }
    SymmetricEigen {
        eigenvectors: v,
        eigenvalues: a.diagonal(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a symmetric matrix with eigenvalues 1 to n and eigenvectors that are not parallel to the axes.
    fn known(n: usize) -> DMatrix<f64> {
        let v = DVector::from_fn(n, |k, _| (k as f64 + 1.0).sin());
        let reflect = DMatrix::identity(n, n) - 2.0 / v.norm_squared() * &v * v.transpose();
        let values = DMatrix::from_diagonal(&DVector::from_fn(n, |k, _| k as f64 + 1.0));
        &reflect * values * reflect
    }

    #[test]
    fn every_symmetric_method_finds_the_known_eigenvalues() {
        for (n, bar) in [(7, 1e-12), (64, 1e-11)] {
            let a = known(n);
            for eigen in [symmetric_eigen(a.clone()), jacobi(a.clone())] {
                let mut values: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
                values.sort_by(f64::total_cmp);
                for (k, value) in values.iter().enumerate() {
                    let off = value - (k as f64 + 1.0);
                    assert!(off.abs() < bar, "{values:?}");
                }
                let off = (eigen.recompose() - &a).norm();
                assert!(off < bar, "{off}");
            }
        }
    }

    #[test]
    fn products_that_underflow_do_not_keep_the_iteration_from_ending() {
        // A marker 1e-154 mm from the origin of its part produces such a matrix in real decks.
        let tiny = 1e-154;
        let a =
            DMatrix::from_row_slice(3, 3, &[2.0, tiny, tiny, tiny, 2.0, tiny, -tiny, tiny, 2.0]);
        let values = eigenvalues(a * 1e3).unwrap();
        assert_eq!(values.len(), 3);
        for value in values {
            assert!((value.re - 2e3).abs() < 1e-9 && value.im == 0.0, "{value}");
        }
        assert!(eigenvalues(DMatrix::from_element(2, 2, f64::NAN)).is_none());
    }

    /// Checks that the product of the three factors equals the matrix. The matrices contain the constraint gradients of an arm on a pin and of
    /// a slider on the arm, for small rotations. With nalgebra, the product differs from some of these matrices by 6e-8.
    #[test]
    fn singular_values_give_the_matrix_back() {
        for k in -400_i32..400 {
            let angle = 1e-6 * f64::from(k) * f64::from(k.abs());
            let (s, c) = angle.sin_cos();
            let (r, l) = (0.6, 1.6);
            let mut G = DMatrix::zeros(12, 12);
            for i in 0..3 {
                G[(i, i)] = 1.0;
                G[(3 + i, 3 + i)] = 1.0 / l;
                // Relative rotation of the two parts; the columns are transformed to axes of the arm below.
                G[(8 + i, 3 + i)] = -1.0 / l;
                G[(8 + i, 9 + i)] = 1.0 / l;
            }
            for (j, (x, y)) in [(-s, c), (0.0, 0.0)].into_iter().enumerate() {
                let z = if j == 0 { 0.0 } else { 1.0 };
                for (column, sign) in [(0, -1.0), (6, 1.0)] {
                    G[(6 + j, column)] = sign * x;
                    G[(6 + j, column + 1)] = sign * y;
                    G[(6 + j, column + 2)] = sign * z;
                }
                G[(6 + j, 5)] = if j == 0 { -r / l } else { 0.0 };
                G[(6 + j, 4)] = if j == 0 { 0.0 } else { r * c / l };
                G[(6 + j, 3)] = if j == 0 { 0.0 } else { -r * s / l };
            }
            let turn = DMatrix::from_row_slice(3, 3, &[c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0]);
            for column in [3, 9] {
                let turned = &turn * G.view((8, column), (3, 3));
                G.view_mut((8, column), (3, 3)).copy_from(&turned);
            }
            let found = singular_values(G.clone(), true, true).unwrap();
            let values = DMatrix::from_diagonal(&found.singular_values);
            let back = found.u.unwrap() * values * found.v_t.unwrap();
            assert!((back - &G).amax() < 1e-14, "{angle}");
        }
    }

    #[test]
    fn the_pseudo_inverse_solves_what_can_be_solved() {
        let a = DMatrix::from_row_slice(2, 3, &[1e200, 0.0, 0.0, 0.0, 1e200, 0.0]);
        let inverse = pseudo_inverse(a, 1e180).unwrap();
        assert!((inverse[(0, 0)] * 1e200 - 1.0).abs() < 1e-12);
        assert_eq!(inverse[(2, 1)], 0.0);
        assert_eq!(
            pseudo_inverse(DMatrix::zeros(2, 3), 0.0).unwrap().shape(),
            (3, 2)
        );
    }
}
