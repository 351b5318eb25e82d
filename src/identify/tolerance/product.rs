//! Products of dense matrices by the matrix kernel that nalgebra uses.

pub(super) use admire_solver::mechanics::dot;
use nalgebra::{DMatrix, DMatrixViewMut, Dyn, MatrixView};

/// Rows or columns that are treated together, so that the rest of the work is a product of matrices.
pub(super) const BLOCK: usize = 16;
/// Columns of a Gram matrix that are computed together.
const GRAM_BLOCK: usize = 32;

/// Number of rows or columns up to which nalgebra multiplies column by column. It then reads beyond the end of a column whose entries are not
/// contiguous, so that views with such columns are copied before.
const FEW: usize = 5;

/// A read-only view of a matrix, part of a matrix or its transpose.
pub(super) type View<'a> = MatrixView<'a, f64, Dyn, Dyn, Dyn, Dyn>;

/// Returns a view of `rows` by `columns` entries from row i and column j on.
pub(super) fn part(
    matrix: &DMatrix<f64>,
    (i, j): (usize, usize),
    (rows, columns): (usize, usize),
) -> View<'_> {
    let step = matrix.nrows();
    if rows == 0 || columns == 0 {
        return View::from_slice_with_strides(&[], rows, columns, 1, rows);
    }
    let values = &matrix.as_slice()[j * step + i..];
    View::from_slice_with_strides(values, rows, columns, 1, step)
}

/// Returns the transpose of [`part`].
pub(super) fn transpose_of_part(
    matrix: &DMatrix<f64>,
    (i, j): (usize, usize),
    (rows, columns): (usize, usize),
) -> View<'_> {
    let step = matrix.nrows();
    if rows == 0 || columns == 0 {
        return View::from_slice_with_strides(&[], columns, rows, 1, columns);
    }
    let values = &matrix.as_slice()[j * step + i..];
    View::from_slice_with_strides(values, columns, rows, step, 1)
}

/// Adds `factor A B` to `keep` times the target. A `keep` of zero overwrites the target. This is the only instance of the product.
pub(super) fn multiply(
    mut to: DMatrixViewMut<'_, f64>,
    keep: f64,
    factor: f64,
    A: &View<'_>,
    B: &View<'_>,
) {
    if to.nrows().min(to.ncols()).min(A.ncols()) > FEW {
        to.gemm(factor, A, B, keep);
    } else {
        to.gemm(factor, &A.clone_owned(), &B.clone_owned(), keep);
    }
}

/// Computes the product of the transpose of columns of A, from column i on, with columns of B, from column j on.
fn of_columns(
    mut to: DMatrixViewMut<'_, f64>,
    A: &DMatrix<f64>,
    i: usize,
    B: &DMatrix<f64>,
    j: usize,
) {
    let (m, (rows, columns)) = (A.nrows(), to.shape());
    if rows.min(columns) > FEW {
        let left = transpose_of_part(A, (0, i), (m, rows));
        multiply(to, 0.0, 1.0, &left, &part(B, (0, j), (m, columns)));
        return;
    }
    let column = |k: usize| k * m..(k + 1) * m;
    for k in 0..columns {
        let b = &B.as_slice()[column(j + k)];
        for row in 0..rows {
            to[(row, k)] = dot(&A.as_slice()[column(i + row)], b);
        }
    }
}

/// Computes the lower triangle of `A'A`; entries above the diagonal are zero.
pub(super) fn gram(A: &DMatrix<f64>) -> DMatrix<f64> {
    let n = A.ncols();
    let mut out = DMatrix::<f64>::zeros(n, n);
    for first in (0..n).step_by(GRAM_BLOCK) {
        let width = GRAM_BLOCK.min(n - first);
        let to = out.view_mut((first, first), (n - first, width));
        of_columns(to, A, first, A, first);
    }
    clear_above_diagonal(&mut out);
    out
}

/// Computes `A'B`.
pub fn transposed(A: &DMatrix<f64>, B: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::<f64>::zeros(A.ncols(), B.ncols());
    let shape = out.shape();
    of_columns(out.view_mut((0, 0), shape), A, 0, B, 0);
    out
}

/// Sets the entries above the diagonal to zero.
pub(super) fn clear_above_diagonal(matrix: &mut DMatrix<f64>) {
    for k in 0..matrix.ncols() {
        let above = k.min(matrix.nrows());
        matrix.view_mut((0, k), (above, 1)).fill(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with sums over the entries, for sizes below, at and above a block.
    #[test]
    fn products_are_sums_over_the_entries() {
        for (m, n, k) in [
            (0, 3, 2),
            (3, 0, 2),
            (1, 1, 1),
            (7, 4, 9),
            (60, 48, 3),
            (9, 101, 50),
        ] {
            let of = |i: usize, j: usize, turn: usize| libm::sin((3 * i + 7 * j + turn) as f64);
            let A = DMatrix::from_fn(m, n, |i, j| of(i, j, 0));
            let B = DMatrix::from_fn(m, k, |i, j| of(i, j, 1));
            let sum = |P: &DMatrix<f64>, i: usize, Q: &DMatrix<f64>, j: usize| -> f64 {
                (0..m).map(|row| P[(row, i)] * Q[(row, j)]).sum()
            };
            let across = DMatrix::from_fn(n, k, |i, j| sum(&A, i, &B, j));
            let lower = |i, j| if i < j { 0.0 } else { sum(&A, i, &A, j) };
            let own = DMatrix::from_fn(n, n, lower);
            assert!(
                (transposed(&A, &B) - across)
                    .iter()
                    .all(|off| off.abs() < 1e-12)
            );
            assert!((gram(&A) - own).iter().all(|off| off.abs() < 1e-12));
        }
    }
}
