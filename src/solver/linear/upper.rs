//! Solutions of triangular systems with the factor U, independent of its storage form.

use std::ops::{Div, Mul};

use super::scalar::Scalar;

/// A row of U: the row and column of its pivot in the matrix, the pivot, and the other entries of the row.
pub(super) struct UpperRow<'a, T> {
    pub row: u32,
    pub column: u32,
    pub pivot: T,
    pub columns: &'a [u32],
    pub factors: &'a [T],
}

/// Solves U x = b by back substitution. `of_row` returns the component of b for a matrix row.
#[inline]
pub(super) fn back<'a, T, R>(
    rows: impl DoubleEndedIterator<Item = UpperRow<'a, T>>,
    x: &mut [R],
    of_row: impl Fn(u32) -> R,
) where
    T: Scalar + 'a,
    R: Scalar + Mul<T, Output = R> + Div<T, Output = R>,
{
    for upper in rows.rev() {
        let mut value = of_row(upper.row);
        for (&column, &factor) in upper.columns.iter().zip(upper.factors) {
            value -= x[column as usize] * factor;
        }
        x[upper.column as usize] = value / upper.pivot;
    }
}

/// Solves the system with the transpose of U by forward substitution. The right side `b`, which is overwritten, has one component per matrix
/// column. The solution `y` has one component per matrix row.
pub(super) fn forwards_transposed<'a, T: Scalar + 'a>(
    rows: impl Iterator<Item = UpperRow<'a, T>>,
    b: &mut [T],
    y: &mut [T],
) {
    for upper in rows {
        let value = b[upper.column as usize] / upper.pivot;
        y[upper.row as usize] = value;
        for (&column, &factor) in upper.columns.iter().zip(upper.factors) {
            b[column as usize] -= factor * value;
        }
    }
}
