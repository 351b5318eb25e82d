//! Operations on columns of dense matrices, written as loops that the compiler can vectorise.

use nalgebra::DMatrix;

/// Computes `a'b`. The sum runs in eight lanes.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
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

/// Adds `factor` times `a` to `to`.
pub(super) fn add(factor: f64, a: &[f64], to: &mut [f64]) {
    for (to, a) in to.iter_mut().zip(a) {
        *to += factor * a;
    }
}

/// Returns two different columns.
pub(super) fn columns_mut(
    matrix: &mut DMatrix<f64>,
    i: usize,
    j: usize,
) -> (&mut [f64], &mut [f64]) {
    let rows = matrix.nrows();
    let (low, high) = (i.min(j), i.max(j));
    let (before, after) = matrix.as_mut_slice().split_at_mut(high * rows);
    let (low, high) = (
        &mut before[low * rows..(low + 1) * rows],
        &mut after[..rows],
    );
    if i < j { (low, high) } else { (high, low) }
}

/// Replaces columns i and j by `c i + s j` and `c j - s i`.
pub(super) fn rotate(matrix: &mut DMatrix<f64>, i: usize, j: usize, c: f64, s: f64) {
    let (a, b) = columns_mut(matrix, i, j);
    for (a, b) in a.iter_mut().zip(b) {
        (*a, *b) = (c * *a + s * *b, c * *b - s * *a);
    }
}
