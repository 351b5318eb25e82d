//! LU factors with a list of all operations that compute them from a matrix.
//!
//! The list contains the target of every product, so that a repeated factorisation needs no search. It has one item per product.

use std::ops::{Div, Mul, Range};

use super::entries::Entries;
use super::pivoting::Eliminated;
use super::scalar::Scalar;
use super::step::{EliminationStep, Scales};
use super::upper::{UpperRow, back, forwards_transposed};

/// An elimination step and the positions of its values. In the list of values, the pivots come first, each followed by its row of U. The
/// columns of L of all steps follow. In a large system, forward substitution then reads no values of U, and back substitution no values of L.
#[derive(Clone, Copy, Debug)]
struct Operation {
    step: EliminationStep,
    /// Index of the pivot in the list of values. The entries of its row of U follow.
    at: u32,
    upper: u32,
    /// Index of the first entry of the column of L.
    below: u32,
    lower: u32,
}

impl Operation {
    #[inline]
    fn across(&self) -> Range<usize> {
        let from = self.at as usize + 1;
        from..from + self.upper as usize
    }

    #[inline]
    fn down(&self) -> Range<usize> {
        let from = self.below as usize;
        from..from + self.lower as usize
    }
}

/// Factors, with the operations that compute them from a matrix.
#[derive(Clone, Debug, Default)]
pub(super) struct Recorded<T> {
    operations: Vec<Operation>,
    /// Index into `values` of each entry of the matrix.
    entries: Vec<u32>,
    /// Column (for U and pivots) or row (for L) of every value.
    index: Vec<u32>,
    values: Vec<T>,
    /// Index into `values` from which each product is subtracted, ordered by elimination step and, within a step, by rows of L.
    targets: Vec<u32>,
    /// Row of U of the current elimination step.
    row: Vec<T>,
}

impl<T: Scalar> Recorded<T> {
    /// Takes over the result of an elimination, including its targets. `entries` is the number of entries of the matrix.
    pub(super) fn of(done: &mut Eliminated<T>, entries: usize) -> Self {
        let mut order = Vec::with_capacity(done.values.len());
        let mut operations = Vec::with_capacity(done.steps.len());
        for (k, &step) in done.steps.iter().enumerate() {
            let (across, down) = done.of_step(k);
            operations.push(Operation {
                step,
                at: order.len() as u32,
                upper: across.len() as u32,
                below: 0,
                lower: down.len() as u32,
            });
            order.push((step.column, done.pivots[k]));
            order.extend(across);
        }
        for (k, operation) in operations.iter_mut().enumerate() {
            operation.below = order.len() as u32;
            order.extend(done.of_step(k).1);
        }
        // Matrix entries that belong to no elimination step go to an additional, unused value at the end.
        let mut moved = vec![order.len() as u32; done.values.len()];
        for (new, (_, old)) in order.iter().enumerate() {
            moved[*old as usize] = new as u32;
        }
        let values = order.iter().map(|(_, old)| done.values[*old as usize]);
        let targets = std::mem::take(&mut done.targets).into_iter();
        Self {
            values: values.chain([T::default()]).collect(),
            index: order.iter().map(|(index, _)| *index).collect(),
            targets: targets.map(|old| moved[old as usize]).collect(),
            entries: moved[..entries].to_vec(),
            operations,
            row: Vec::new(),
        }
    }

    /// Returns the number of entries in the factors.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.index.len()
    }

    /// Repeats the operations with another matrix. Returns false if a pivot has become too small, judged by the scales of the rows and columns
    /// and by the allowed `growth`.
    pub(super) fn repeat(
        &mut self,
        matrix: &Entries<'_, T>,
        scales: Scales<'_>,
        growth: f64,
    ) -> bool {
        let (zero, values) = (T::default(), &mut self.values[..]);
        values.fill(zero);
        for (&at, value) in self.entries.iter().zip(matrix.values) {
            values[at as usize] = *value;
        }
        let mut targets = &self.targets[..];
        for operation in &self.operations {
            let step = &operation.step;
            let Some(pivot) = step.pivot(
                values[operation.at as usize],
                scales.row[step.row as usize],
                scales.column[step.column as usize],
                growth,
            ) else {
                return false;
            };
            self.row.clear();
            self.row.extend_from_slice(&values[operation.across()]);
            for k in operation.down() {
                let (now, later) = targets.split_at(operation.upper as usize);
                targets = later;
                let value = values[k];
                if value == zero {
                    continue;
                }
                if !pivot.is_acceptable(value, scales.row[self.index[k] as usize]) {
                    return false;
                }
                let multiplier = value * pivot.inverse;
                values[k] = multiplier;
                for (&target, &factor) in now.iter().zip(&self.row) {
                    values[target as usize] -= multiplier * factor;
                }
            }
        }
        true
    }

    /// Iterates over the rows of U.
    fn upper(&self) -> impl DoubleEndedIterator<Item = UpperRow<'_, T>> {
        self.operations.iter().map(|operation| UpperRow {
            row: operation.step.row,
            column: operation.step.column,
            pivot: self.values[operation.at as usize],
            columns: &self.index[operation.across()],
            factors: &self.values[operation.across()],
        })
    }

    /// Iterates over the columns of L. Each item contains the matrix row of the pivot, the rows below it, and their multipliers.
    fn lower(&self) -> impl DoubleEndedIterator<Item = (u32, &[u32], &[T])> {
        self.operations.iter().map(|operation| {
            let down = operation.down();
            let row = operation.step.row;
            (row, &self.index[down.clone()], &self.values[down])
        })
    }

    /// Solves for the right side `b`, which is overwritten, and writes the solution to `x`. On entry, `x` must be zero for unknowns without a
    /// pivot.
    pub(super) fn solve_into<R>(&self, b: &mut [R], x: &mut [R])
    where
        R: Scalar + Mul<T, Output = R> + Div<T, Output = R>,
    {
        for (row, rows, multipliers) in self.lower() {
            let value = b[row as usize];
            if value == R::default() {
                continue;
            }
            for (&row, &multiplier) in rows.iter().zip(multipliers) {
                b[row as usize] -= value * multiplier;
            }
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
            let mut value = y[row as usize];
            for (&row, &multiplier) in rows.iter().zip(multipliers) {
                value -= multiplier * y[row as usize];
            }
            y[row as usize] = value;
        }
    }
}
