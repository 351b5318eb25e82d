//! Cholesky factor of a symmetric positive definite matrix, computed by the library faer.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_inverse::invert_lower_triangular;
use faer::{Accum, Auto, Par, Spec};
use nalgebra::{DMatrix, DVector};

use super::product::{dot, read, write};

/// Cholesky factor `L` of a symmetric positive definite matrix `M = L L'`.
#[derive(Clone, Debug)]
pub struct Factor {
    /// Lower triangular factor. Entries above the diagonal are undefined.
    L: DMatrix<f64>,
}

impl Factor {
    /// Factorises the symmetric matrix `M`, of which only the lower triangle is read. Returns `None` if `M` is not positive definite.
    pub fn new(mut M: DMatrix<f64>) -> Option<Self> {
        let n = M.nrows();
        let params: Spec<llt::factor::LltParams, f64> = Spec::new(Auto::<f64>::auto());
        let mut memory =
            MemBuffer::new(llt::factor::cholesky_in_place_scratch(n, Par::Seq, params));
        llt::factor::cholesky_in_place(
            write(&mut M),
            llt::factor::LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            params,
        )
        .ok()?;
        let factor = Self { L: M };
        factor.ln_det().is_finite().then_some(factor)
    }

    /// Returns the natural logarithm of the determinant of `M`.
    pub(crate) fn ln_det(&self) -> f64 {
        let diagonal = (0..self.L.nrows()).map(|k| libm::log(self.L[(k, k)]));
        2.0 * diagonal.sum::<f64>()
    }

    /// Computes `M^-1 b`.
    pub fn solve(&self, b: &DVector<f64>) -> DVector<f64> {
        let n = b.len();
        let mut x = b.clone();
        for k in 0..n {
            let column = &self.L.as_slice()[k * n..(k + 1) * n];
            let value = x[k] / column[k];
            x[k] = value;
            for (x, l) in x.as_mut_slice()[k + 1..].iter_mut().zip(&column[k + 1..]) {
                *x -= value * l;
            }
        }
        for k in (0..n).rev() {
            let column = &self.L.as_slice()[k * n..(k + 1) * n];
            let sum = dot(&x.as_slice()[k + 1..], &column[k + 1..]);
            x[k] = (x[k] - sum) / column[k];
        }
        x
    }

    /// Computes `v'M v`.
    pub(crate) fn quadratic(&self, v: &DVector<f64>) -> f64 {
        let n = v.len();
        let of = |k: usize| {
            let column = &self.L.as_slice()[k * n..(k + 1) * n];
            dot(&column[k..], &v.as_slice()[k..])
        };
        (0..n).map(|k| of(k).powi(2)).sum()
    }

    /// Computes the inverse of the factor, `L^-1`.
    fn inverse_of_factor(&self) -> DMatrix<f64> {
        let n = self.L.nrows();
        let mut V = DMatrix::<f64>::zeros(n, n);
        invert_lower_triangular(write(&mut V), read(&self.L), Par::Seq);
        V
    }

    /// Returns the trace of `M^-1`.
    pub fn inverse_trace(&self) -> f64 {
        self.inverse_of_factor().norm_squared()
    }

    /// Computes the lower triangle of `M^-1`; entries above the diagonal are zero.
    pub(crate) fn inverse(&self) -> DMatrix<f64> {
        let n = self.L.nrows();
        let mut out = DMatrix::<f64>::zeros(n, n);
        let V = self.inverse_of_factor();
        let V = read(&V);
        triangular::matmul(
            write(&mut out),
            BlockStructure::TriangularLower,
            Accum::Replace,
            V.transpose(),
            BlockStructure::TriangularUpper,
            V,
            BlockStructure::TriangularLower,
            1.0,
            Par::Seq,
        );
        out
    }
}

#[cfg(test)]
mod tests {
    use super::super::product::gram;
    use super::*;
    use admire_study::noise::Noise;

    /// Compares determinant, solution and inverse with the results of nalgebra for the same matrix.
    #[test]
    fn factor_and_inverse_are_those_of_another_library() {
        for n in [0, 1, 2, 5, 40, 131] {
            let mut noise = Noise::new(5, "factor");
            let A = DMatrix::from_fn(n + 20, n, |_, _| noise.normal());
            let b = DVector::from_fn(n, |_, _| noise.normal());
            let G = gram(&A);
            let M = A.tr_mul(&A);
            assert!((&G - M.lower_triangle()).amax() < 1e-12 * (1.0 + M.amax()) || n == 0);
            let own = Factor::new(G).unwrap();
            let other = nalgebra::Cholesky::new(M.clone()).unwrap();
            if n == 0 {
                continue;
            }
            assert!((own.solve(&b) - other.solve(&b)).amax() < 1e-9);
            assert!((own.inverse() - other.inverse().lower_triangle()).amax() < 1e-9);
            let trace = own.inverse_trace() / other.inverse().trace();
            assert!((trace - 1.0).abs() < 1e-9);
            let quadratic = own.quadratic(&b) / b.dot(&(&M * &b));
            assert!((quadratic - 1.0).abs() < 1e-12);
            assert!((own.ln_det() - other.determinant().ln()).abs() < 1e-9);
        }
        assert!(Factor::new(-DMatrix::<f64>::identity(3, 3)).is_none());
        assert!(Factor::new(DMatrix::from_element(2, 2, f64::NAN)).is_none());
    }
}
