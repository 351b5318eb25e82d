//! Square root of a covariance matrix.

use nalgebra::{Cholesky, DMatrix};

use admire_solver::mechanics::eigen::symmetric_eigen;

/// Returns a matrix `L` with `L L' = C`. Uses the Cholesky factorisation if `C` is positive definite, otherwise the eigenvectors of `C`.
pub fn covariance_root(C: &DMatrix<f64>) -> DMatrix<f64> {
    if let Some(factor) = Cholesky::new(C.clone()) {
        return factor.l();
    }
    if C.is_empty() {
        return C.clone();
    }
    let eigen = symmetric_eigen(C.clone());
    let mut L = eigen.eigenvectors;
    for (mut column, lambda) in L.column_iter_mut().zip(eigen.eigenvalues.iter()) {
        column *= lambda.max(0.0).sqrt();
    }
    L
}
