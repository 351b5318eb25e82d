//! The three-stage Radau IIA method: its coefficients, and the transformation that decouples its stages.
//!
//! Source: Hairer, Wanner, Solving Ordinary Differential Equations II, IV.8.

use nalgebra::{Complex, Matrix3};

const ROOT: f64 = 2.449_489_742_783_178;

/// Times of the stages, as shares of the step.
pub(super) const C: [f64; 3] = [(4.0 - ROOT) / 10.0, (4.0 + ROOT) / 10.0, 1.0];

/// Runge-Kutta matrix A of the method.
pub(super) const A: [[f64; 3]; 3] = [
    [
        (88.0 - 7.0 * ROOT) / 360.0,
        (296.0 - 169.0 * ROOT) / 1800.0,
        (-2.0 + 3.0 * ROOT) / 225.0,
    ],
    [
        (296.0 + 169.0 * ROOT) / 1800.0,
        (88.0 + 7.0 * ROOT) / 360.0,
        (-2.0 - 3.0 * ROOT) / 225.0,
    ],
    [(16.0 - ROOT) / 36.0, (16.0 + ROOT) / 36.0, 1.0 / 9.0],
];

/// Weights of the stages in the error estimate.
pub(super) const E: [f64; 3] = [
    (-13.0 - 7.0 * ROOT) / 3.0,
    (-13.0 + 7.0 * ROOT) / 3.0,
    -1.0 / 3.0,
];

/// Real eigenvalue of the inverse of A.
pub(super) const GAMMA: f64 = 3.637_834_252_744_496;
/// One eigenvalue of the complex pair of the inverse of A.
pub(super) const ALPHA_BETA: Complex<f64> =
    Complex::new(2.681_082_873_627_752, 3.050_430_199_247_411);

/// Matrices derived from A: its inverse B, the transformation T that makes B block-diagonal, and the inverse of T.
#[derive(Clone, Debug)]
pub(super) struct Tableau {
    pub B: [[f64; 3]; 3],
    pub T: [[f64; 3]; 3],
    pub T_inverse: [[f64; 3]; 3],
}

impl Tableau {
    pub(crate) fn new() -> Self {
        let B = Matrix3::from_fn(|i, j| A[i][j])
            .try_inverse()
            .expect("the matrix of Radau IIA is regular");
        // The columns of T are the real eigenvector, the real part of the complex eigenvector, and the negative of its imaginary part. Then
        // T^-1 B T = [gamma; [alpha, -beta; beta, alpha]].
        let eigenvector = |value: Complex<f64>| {
            let M = B.map(|b| Complex::new(b, 0.0)) - Matrix3::from_diagonal_element(value);
            // The cross product of two rows spans the null space of the singular matrix.
            let (a, b) = (M.row(0).transpose(), M.row(1).transpose());
            let v = a.cross(&b);
            v / v[2]
        };
        let real = eigenvector(Complex::new(GAMMA, 0.0));
        let pair = eigenvector(ALPHA_BETA);
        // B (u + i v) = (alpha + i beta)(u + i v): B u = alpha u - beta v, B v = beta u + alpha v; the columns are u and -v.
        let T = Matrix3::from_fn(|i, j| match j {
            0 => real[i].re,
            1 => pair[i].re,
            _ => -pair[i].im,
        });
        let T_inverse = T
            .try_inverse()
            .expect("eigenvectors of different eigenvalues are independent");
        let rows = |M: &Matrix3<f64>| std::array::from_fn(|i| std::array::from_fn(|j| M[(i, j)]));
        Self {
            B: rows(&B),
            T: rows(&T),
            T_inverse: rows(&T_inverse),
        }
    }
}

/// Returns the weights with which stage values are interpolated at time `s`, counted in steps from the start of the step. The interpolant is
/// the cubic through zero at time 0 and through the stage values at the stage times.
pub(super) fn lagrange(s: f64) -> [f64; 3] {
    std::array::from_fn(|i| {
        let mut weight = s / C[i];
        for j in 0..3 {
            if j != i {
                weight *= (s - C[j]) / (C[i] - C[j]);
            }
        }
        weight
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coefficients_satisfy_their_conditions() {
        for i in 0..3 {
            for q in 1..=3 {
                let sum: f64 = (0..3).map(|j| A[i][j] * C[j].powi(q - 1)).sum();
                assert!((sum - C[i].powi(q) / f64::from(q)).abs() < 1e-15, "{i} {q}");
            }
        }
        for q in 1..=5 {
            let sum: f64 = (0..3).map(|j| A[2][j] * C[j].powi(q - 1)).sum();
            assert!((sum - 1.0 / f64::from(q)).abs() < 1e-15, "{q}");
        }
    }

    #[test]
    fn the_transformation_takes_the_stages_apart() {
        let tableau = Tableau::new();
        let matrix = |M: &[[f64; 3]; 3]| Matrix3::from_fn(|i, j| M[i][j]);
        let parts = matrix(&tableau.T_inverse) * matrix(&tableau.B) * matrix(&tableau.T);
        let (a, b) = (ALPHA_BETA.re, ALPHA_BETA.im);
        let expected = Matrix3::new(GAMMA, 0.0, 0.0, 0.0, a, -b, 0.0, b, a);
        assert!((parts - expected).norm() < 1e-13, "{parts}");
    }

    #[test]
    fn the_interpolation_is_exact_for_cubics() {
        let f = |s: f64| s * (1.0 - 2.0 * s + 0.7 * s * s);
        for s in [0.2, 0.9, 1.7] {
            let weights = lagrange(s);
            let value: f64 = (0..3).map(|i| weights[i] * f(C[i])).sum();
            assert!((value - f(s)).abs() < 1e-14);
        }
    }
}
