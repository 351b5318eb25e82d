//! LU factors in the form that solutions read: row by row, without zeros.
//!
//! At least half of the entries in the factors of a mechanism are zero, because axes are parallel to those of the model and blocks are
//! diagonal.

use std::ops::{Div, Mul};

use super::scalar::Scalar;
use super::upper::{UpperRow, back, forwards_transposed};

/// A row of the factors: its row and column in the matrix, and the ends of its entries of L and U.
#[derive(Clone, Copy, Debug, Default)]
struct RowRange {
    row: u32,
    column: u32,
    lower: u32,
    upper: u32,
}

/// Rows of L and U in the order of elimination.
#[derive(Clone, Debug, Default)]
pub(super) struct Factors<T> {
    /// Of every row, behind one in front of the first.
    ends: Vec<RowRange>,
    pivots: Vec<T>,
    /// Matrix rows of which the rows of L subtract multiples.
    lower_rows: Vec<u32>,
    /// Multipliers of L.
    lower: Vec<T>,
    upper_columns: Vec<u32>,
    upper: Vec<T>,
}

/// Factors while they are written row by row.
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
    /// Appends an entry of L to the current row.
    #[inline]
    pub(super) fn push_lower(&mut self, row: u32, multiplier: T) {
        let at = self.counts.0;
        self.lower_rows[at] = row;
        self.lower[at] = multiplier;
        self.counts.0 = at + 1;
    }

    /// Appends an entry of U to the current row, unless it is zero. The code has no branch, which would be unpredictable.
    #[inline]
    pub(super) fn push_upper(&mut self, column: u32, value: T) {
        let at = self.counts.1;
        self.upper_columns[at] = column;
        self.upper[at] = value;
        self.counts.1 = at + usize::from(value != T::default());
    }

    /// Ends the current row.
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

    /// Returns columns and values of U in the k-th row.
    #[inline]
    pub(super) fn upper(&self, k: usize) -> (&[u32], &[T]) {
        let range = self.ends[k].upper as usize..self.ends[k + 1].upper as usize;
        (&self.upper_columns[range.clone()], &self.upper[range])
    }
}

impl<T: Scalar> Factors<T> {
    /// Starts new factors, with room for `lower` entries of L and `upper` entries of U.
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

    /// Iterates over the rows of L: the matrix row, the rows of which it subtracts multiples, and the multipliers.
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

    /// Solves for the right side `b`, which is overwritten, and writes the solution to `x`. Unknowns without a pivot must be zero in `x` on
    /// entry.
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

    /// Completes `x`, in which an unknown without a pivot is given, to a null vector of the matrix.
    pub(super) fn follow_free(&self, x: &mut [T]) {
        back(self.upper(), x, |_| T::default());
    }

    /// Solves with the transposed matrix and writes the solution to `y`. Rows without a pivot must be zero in `y` on entry.
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
