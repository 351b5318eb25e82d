//! Cholesky factors and inverses of dense triangular matrices. The work is done in blocks of columns, most of it as products of matrices.

use nalgebra::DMatrix;

use super::product::{BLOCK, clear_above_diagonal, multiply, part, transpose_of_part};

/// Replaces the lower triangle of a symmetric matrix by its Cholesky factor; only that triangle is read. Returns `None` if the matrix is not
/// positive definite or an entry is not finite.
pub(super) fn cholesky(M: &mut DMatrix<f64>) -> Option<()> {
    let n = M.nrows();
    for first in (0..n).step_by(BLOCK) {
        let (width, height) = (BLOCK.min(n - first), n - first);
        // The columns before the block are those of the factor already.
        let mut block = M.view((first, first), (height, width)).into_owned();
        let left = part(M, (first, 0), (height, first));
        let right = transpose_of_part(M, (first, 0), (width, first));
        let shape = block.shape();
        multiply(block.view_mut((0, 0), shape), 1.0, -1.0, &left, &right);
        factorise_columns(&mut block)?;
        M.view_mut((first, first), (height, width))
            .copy_from(&block);
    }
    Some(())
}

/// Replaces the first columns of a symmetric matrix by those of its factor. Only the lower triangle is read and written. Returns `None` if a
/// pivot is not positive and finite.
fn factorise_columns(block: &mut DMatrix<f64>) -> Option<()> {
    let (height, width) = block.shape();
    for k in 0..width {
        let (before, from) = block.as_mut_slice().split_at_mut(k * height);
        let column = &mut from[k..height];
        for earlier in before.chunks(height) {
            let factor = earlier[k];
            for (value, by) in column.iter_mut().zip(&earlier[k..]) {
                *value -= factor * by;
            }
        }
        if !(column[0] > 0.0 && column[0].is_finite()) {
            return None;
        }
        let pivot = column[0].sqrt();
        for value in column {
            *value /= pivot;
        }
    }
    Some(())
}

/// Computes the inverse of a lower triangular matrix; entries above the diagonal are not read, and zero in the inverse.
pub(super) fn inverse_of(L: &DMatrix<f64>) -> DMatrix<f64> {
    let n = L.nrows();
    let mut V = DMatrix::<f64>::zeros(n, n);
    for first in (0..n).step_by(BLOCK) {
        let width = BLOCK.min(n - first);
        // Rows of the block: -L_ii^-1 L_i V, where L_i are the entries before the diagonal block L_ii.
        let own = inverse_of_block(L, first, width);
        let mut sums = DMatrix::<f64>::zeros(width, first);
        let (left, right) = (
            part(L, (first, 0), (width, first)),
            part(&V, (0, 0), (first, first)),
        );
        let to = sums.view_mut((0, 0), (width, first));
        multiply(to, 0.0, 1.0, &left, &right);
        let (left, right) = (
            part(&own, (0, 0), own.shape()),
            part(&sums, (0, 0), sums.shape()),
        );
        let to = V.view_mut((first, 0), (width, first));
        multiply(to, 0.0, -1.0, &left, &right);
        V.view_mut((first, first), (width, width)).copy_from(&own);
    }
    V
}

/// Computes the inverse of a block on the diagonal of a lower triangular matrix.
fn inverse_of_block(L: &DMatrix<f64>, first: usize, width: usize) -> DMatrix<f64> {
    let mut out = DMatrix::<f64>::zeros(width, width);
    for j in 0..width {
        out[(j, j)] = 1.0;
        for k in j..width {
            let value = out[(k, j)] / L[(first + k, first + k)];
            out[(k, j)] = value;
            for i in k + 1..width {
                out[(i, j)] -= value * L[(first + i, first + k)];
            }
        }
    }
    out
}

/// Computes the lower triangle of `(L L')^-1`; entries above the diagonal are zero.
pub(super) fn inverse_of_product(L: &DMatrix<f64>) -> DMatrix<f64> {
    let n = L.nrows();
    let mut out = DMatrix::<f64>::zeros(n, n);
    let V = inverse_of(L);
    for first in (0..n).step_by(BLOCK) {
        let (width, height) = (BLOCK.min(n - first), n - first);
        let left = transpose_of_part(&V, (first, first), (height, width));
        let right = part(&V, (first, 0), (height, first + width));
        let to = out.view_mut((first, 0), (width, first + width));
        multiply(to, 0.0, 1.0, &left, &right);
    }
    clear_above_diagonal(&mut out);
    out
}
