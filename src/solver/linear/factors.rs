//! LU factors that are stored row by row without zeros, as forward and back substitution read them.
//!
//! At least half of the entries in the factors of a mechanism are zero, because many axes are parallel to axes of the model and many blocks are
//! diagonal.

use std::ops::{Div, Mul};

use super::scalar::Scalar;
use super::upper::{UpperRow, back, forwards_transposed};

/// A row of the factors: the row and column of its pivot in the matrix, and the ends of its entries in the lists of L and U.
#[derive(Clone, Copy, Debug, Default)]
struct RowRange {
    row: u32,
    column: u32,
    lower: u32,
    upper: u32,
}

/// L and U, row by row in the order of elimination.
#[derive(Clone, Debug, Default)]
pub(super) struct Factors<T> {
    /// Ranges of the rows. The first item is a sentinel: the entries of row k lie between the ends in items k and k + 1.
    ends: Vec<RowRange>,
    pivots: Vec<T>,
    /// For each entry of L, the matrix row whose multiple is subtracted.
    lower_rows: Vec<u32>,
    /// For each entry of L, the multiplier.
    lower: Vec<T>,
    upper_columns: Vec<u32>,
    upper: Vec<T>,
}

/// Access to [`Factors`] that are being written row by row.
pub(super) struct Written<'a, T> {
    ends: &'a mut Vec<RowRange>,
    pivots: &'a mut Vec<T>,
    lower_rows: &'a mut [u32],
    lower: &'a mut [T],
    upper_columns: &'a mut [u32],
    upper: &'a mut [T],
    /// Numbers of entries of L and U written so far.
    counts: (usize, usize),
}

impl<T: Scalar> Written<'_, T> {
    /// Appends an entry of L to the current row: `multiplier` times the matrix row `row` is subtracted from it.
    #[inline]
    pub(super) fn push_lower(&mut self, row: u32, multiplier: T) {
        let at = self.counts.0;
        self.lower_rows[at] = row;
        self.lower[at] = multiplier;
        self.counts.0 = at + 1;
    }

    /// Appends an entry of U to the current row, unless its value is zero. The code contains no branch, because a branch would be
    /// unpredictable.
    #[inline]
    pub(super) fn push_upper(&mut self, column: u32, value: T) {
        let at = self.counts.1;
        self.upper_columns[at] = column;
        self.upper[at] = value;
        self.counts.1 = at + usize::from(value != T::default());
    }

    /// Ends the current row, whose pivot is at (`row`, `column`) of the matrix.
    #[inline]
    pub(super) fn end_row(&mut self, row: u32, column: u32, pivot: T) {
        self.ends.push(RowRange {
            row,
            column,
            lower: self.counts.0 as u32,
            upper: self.counts.1 as u32,
        });
        self.pivots.push(pivot);
    }

    /// Returns the columns and the values of the entries in the k-th row of U.
    #[inline]
    pub(super) fn upper(&self, k: usize) -> (&[u32], &[T]) {
        let range = self.ends[k].upper as usize..self.ends[k + 1].upper as usize;
        (&self.upper_columns[range.clone()], &self.upper[range])
    }
}

impl<T: Scalar> Factors<T> {
    /// Discards the factors and starts to write new ones, with room for `lower` entries of L and `upper` entries of U.
    pub(super) fn begin(&mut self, lower: usize, upper: usize) -> Written<'_, T> {
        self.ends.clear();
        self.ends.push(RowRange::default());
        self.pivots.clear();
        self.lower_rows.resize(lower, 0);
        self.lower.resize(lower, T::default());
        self.upper_columns.resize(upper, 0);
        self.upper.resize(upper, T::default());
        Written {
            ends: &mut self.ends,
            pivots: &mut self.pivots,
            lower_rows: &mut self.lower_rows,
            lower: &mut self.lower,
            upper_columns: &mut self.upper_columns,
            upper: &mut self.upper,
            counts: (0, 0),
        }
    }

    /// Iterates over the rows of L. Each item contains the matrix row, the rows whose multiples are subtracted from it, and the multipliers.
    fn lower(&self) -> impl DoubleEndedIterator<Item = (u32, &[u32], &[T])> {
        self.ends.windows(2).map(|pair| {
            let range = pair[0].lower as usize..pair[1].lower as usize;
            let rows = &self.lower_rows[range.clone()];
            (pair[1].row, rows, &self.lower[range])
        })
    }

    /// Iterates over the rows of U.
    fn upper(&self) -> impl DoubleEndedIterator<Item = UpperRow<'_, T>> {
        let rows = self.ends.windows(2).zip(&self.pivots);
        rows.map(|(pair, &pivot)| {
            let range = pair[0].upper as usize..pair[1].upper as usize;
            UpperRow {
                row: pair[1].row,
                column: pair[1].column,
                pivot,
                columns: &self.upper_columns[range.clone()],
                factors: &self.upper[range],
            }
        })
    }

    /// Solves for the right side `b`, which is overwritten, and writes the solution to `x`. On entry, `x` must be zero for unknowns without a
    /// pivot.
    pub(super) fn solve_into<R>(&self, b: &mut [R], x: &mut [R])
    where
        R: Scalar + Mul<T, Output = R> + Div<T, Output = R>,
    {
        for (row, rows, multipliers) in self.lower().filter(|lower| !lower.1.is_empty()) {
            let mut value = b[row as usize];
            for (&row, &multiplier) in rows.iter().zip(multipliers) {
                value -= b[row as usize] * multiplier;
            }
            b[row as usize] = value;
        }
        back(self.upper(), x, |row| b[row as usize]);
    }

    /// Completes `x` to a null vector of the matrix. On entry, `x` contains the values of the unknowns without a pivot.
    pub(super) fn follow_free(&self, x: &mut [T]) {
        back(self.upper(), x, |_| T::default());
    }

    /// Solves the transposed system for the right side `b`, which is overwritten, and writes the solution to `y`. On entry, `y` must be zero
    /// for rows without a pivot.
    pub(super) fn solve_transposed(&self, b: &mut [T], y: &mut [T]) {
        forwards_transposed(self.upper(), b, y);
        for (row, rows, multipliers) in self.lower().rev() {
            let value = y[row as usize];
            for (&row, &multiplier) in rows.iter().zip(multipliers) {
                y[row as usize] -= multiplier * value;
            }
        }
    }
}
