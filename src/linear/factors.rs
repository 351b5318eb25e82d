//! LU factors as the solutions read them: row by row, without their zeros.
//!
//! Half and more of the factors of a mechanism are zeros: axes that lie along those of the model, blocks that are diagonal.

use std::ops::{Div, Mul, Range};

use super::scalar::Scalar;

/// A row of the factors: its row and column of the matrix, and where its entries of L and U end.
#[derive(Clone, Copy, Debug)]
struct Ends {
    row: u32,
    column: u32,
    lower: u32,
    upper: u32,
}

/// Rows of L and U in the order of the elimination.
#[derive(Clone, Debug, Default)]
pub(super) struct Factors<T> {
    ends: Vec<Ends>,
    pivots: Vec<T>,
    /// Rows of the matrix whose multiples are taken off, and their multipliers.
    lower_rows: Vec<u32>,
    lower: Vec<T>,
    upper_columns: Vec<u32>,
    upper: Vec<T>,
}

/// Factors that are written row by row.
pub(super) struct Written<'a, T> {
    ends: &'a mut Vec<Ends>,
    pivots: &'a mut Vec<T>,
    lower_rows: &'a mut [u32],
    lower: &'a mut [T],
    upper_columns: &'a mut [u32],
    upper: &'a mut [T],
    /// How many there are of L and U.
    counts: (usize, usize),
}

impl<T: Scalar> Written<'_, T> {
    /// Adds to L in the row that comes next.
    #[inline]
    pub(super) fn push_lower(&mut self, row: u32, multiplier: T) {
        let at = self.counts.0;
        self.lower_rows[at] = row;
        self.lower[at] = multiplier;
        self.counts.0 = at + 1;
    }

    /// Adds to U in the row that comes next, unless it is zero: without a branch, which nobody could foretell.
    #[inline]
    pub(super) fn push_upper(&mut self, column: u32, value: T) {
        let at = self.counts.1;
        self.upper_columns[at] = column;
        self.upper[at] = value;
        self.counts.1 = at + usize::from(value != T::default());
    }

    /// Ends a row.
    #[inline]
    pub(super) fn end_row(&mut self, row: u32, column: u32, pivot: T) {
        self.ends.push(Ends {
            row,
            column,
            lower: self.counts.0 as u32,
            upper: self.counts.1 as u32,
        });
        self.pivots.push(pivot);
    }

    /// Columns and values of U of the k-th row.
    #[inline]
    pub(super) fn upper(&self, k: usize) -> (&[u32], &[T]) {
        let from = k.checked_sub(1).map_or(0, |k| self.ends[k].upper);
        let range = from as usize..self.ends[k].upper as usize;
        (&self.upper_columns[range.clone()], &self.upper[range])
    }
}

impl<T: Scalar> Factors<T> {
    /// Begins anew, with room for so many entries of L and U.
    pub(super) fn begin(&mut self, lower: usize, upper: usize) -> Written<'_, T> {
        self.ends.clear();
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

    /// Every row with its entries of L, from the first to the last.
    fn forwards(&self) -> impl Iterator<Item = (Ends, Range<usize>)> + '_ {
        let mut from = 0;
        self.ends.iter().map(move |ends| {
            let range = from..ends.lower as usize;
            from = range.end;
            (*ends, range)
        })
    }

    /// Every row with its entries of U and its pivot, from the last to the first.
    fn backwards(&self) -> impl Iterator<Item = (Ends, Range<usize>, T)> + '_ {
        let mut to = self.ends.last().map_or(0, |ends| ends.upper as usize);
        let mut next = self.ends.len();
        std::iter::from_fn(move || {
            next = next.checked_sub(1)?;
            let from = next.checked_sub(1).map_or(0, |k| self.ends[k].upper);
            let range = from as usize..to;
            to = range.start;
            Some((self.ends[next], range, self.pivots[next]))
        })
    }

    /// Solves for the right side `b`, which is used up; the solution goes to `x`, where unknowns without a pivot are zero.
    pub(super) fn solve_into<R>(&self, b: &mut [R], x: &mut [R])
    where
        R: Scalar + Mul<T, Output = R> + Div<T, Output = R>,
    {
        for (ends, range) in self.forwards().filter(|(_, range)| !range.is_empty()) {
            let mut value = b[ends.row as usize];
            let rows = &self.lower_rows[range.clone()];
            for (&row, &multiplier) in rows.iter().zip(&self.lower[range]) {
                value -= b[row as usize] * multiplier;
            }
            b[ends.row as usize] = value;
        }
        self.back(x, |row| b[row as usize]);
    }

    /// From `of_row` to the solution by U.
    fn back<R>(&self, x: &mut [R], of_row: impl Fn(u32) -> R)
    where
        R: Scalar + Mul<T, Output = R> + Div<T, Output = R>,
    {
        for (ends, range, pivot) in self.backwards() {
            let mut value = of_row(ends.row);
            let columns = &self.upper_columns[range.clone()];
            for (&column, &factor) in columns.iter().zip(&self.upper[range]) {
                value -= x[column as usize] * factor;
            }
            x[ends.column as usize] = value / pivot;
        }
    }

    /// Changes `x`, where an unknown without a pivot is given, into a motion that nothing resists.
    pub(super) fn follow_free(&self, x: &mut [T]) {
        self.back(x, |_| T::default());
    }

    /// Solves with the transposed matrix; rows without a pivot have zero in `y`.
    pub(super) fn solve_transposed(&self, b: &mut [T], y: &mut [T]) {
        // U' first: the columns of the matrix are its rows now.
        let mut from = 0;
        for (ends, &pivot) in self.ends.iter().zip(&self.pivots) {
            let range = from..ends.upper as usize;
            from = range.end;
            let value = b[ends.column as usize] / pivot;
            y[ends.row as usize] = value;
            let columns = &self.upper_columns[range.clone()];
            for (&column, &factor) in columns.iter().zip(&self.upper[range]) {
                b[column as usize] -= factor * value;
            }
        }
        let mut to = self.ends.last().map_or(0, |ends| ends.lower as usize);
        for k in (0..self.ends.len()).rev() {
            let from = k.checked_sub(1).map_or(0, |k| self.ends[k].lower);
            let range = from as usize..to;
            to = range.start;
            let value = y[self.ends[k].row as usize];
            let rows = &self.lower_rows[range.clone()];
            for (&row, &multiplier) in rows.iter().zip(&self.lower[range]) {
                y[row as usize] -= multiplier * value;
            }
        }
    }
}
