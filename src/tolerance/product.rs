//! Products of dense matrices, by faer.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;

/// The lower triangle of `A'A`; what stands above is zero.
pub(super) fn gram(A: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::<f64>::zeros(A.ncols(), A.ncols());
    let (to, A) = (write(&mut out), read(A));
    let (whole, lower) = (BlockStructure::Rectangular, BlockStructure::TriangularLower);
    triangular::matmul(
        to,
        lower,
        Accum::Replace,
        A.transpose(),
        whole,
        A,
        whole,
        1.0,
        Par::Seq,
    );
    out
}

/// `A'B`.
pub(crate) fn transposed(A: &DMatrix<f64>, B: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::<f64>::zeros(A.ncols(), B.ncols());
    let to = write(&mut out);
    matmul(
        to,
        Accum::Replace,
        read(A).transpose(),
        read(B),
        1.0,
        Par::Seq,
    );
    out
}

/// A matrix as faer reads it.
pub(super) fn read(matrix: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

/// A matrix as faer writes it.
pub(super) fn write(matrix: &mut DMatrix<f64>) -> MatMut<'_, f64> {
    let (rows, columns) = matrix.shape();
    MatMut::from_column_major_slice_mut(matrix.as_mut_slice(), rows, columns)
}
