//! Products of dense matrices, computed by the library faer, and the dot product.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;

/// Computes the lower triangle of `A'A`; entries above the diagonal are zero.
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

/// Computes `A'B`.
pub fn transposed(A: &DMatrix<f64>, B: &DMatrix<f64>) -> DMatrix<f64> {
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

/// Computes `a'b`. The sum runs in eight lanes, so the compiler can vectorise the loop.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a_blocks, b_blocks) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest = a_blocks.remainder().iter().zip(b_blocks.remainder());
    let rest: f64 = rest.map(|(a, b)| a * b).sum();
    for (a, b) in a_blocks.zip(b_blocks) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Returns a read-only view of a matrix for faer.
pub(super) fn read(matrix: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

/// Returns a mutable view of a matrix for faer.
pub(super) fn write(matrix: &mut DMatrix<f64>) -> MatMut<'_, f64> {
    let (rows, columns) = matrix.shape();
    MatMut::from_column_major_slice_mut(matrix.as_mut_slice(), rows, columns)
}
