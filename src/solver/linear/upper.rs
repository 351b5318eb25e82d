//! Solutions by the factor U, however it is kept.

use std::ops::{Div, Mul};

use super::scalar::Scalar;

/// A row of U: its row and column of the matrix, its pivot, and the entries beside it.
pub(super) struct UpperRow<'a, T> {
    pub row: u32,
    pub column: u32,
    pub pivot: T,
    pub columns: &'a [u32],
    pub factors: &'a [T],
}

/// From `of_row` to the solution.
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

/// The same with the transposed factor, whose rows are the columns of the matrix: from `b`, which is used up, to `y`.
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
