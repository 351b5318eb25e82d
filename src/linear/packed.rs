//! What of LU factors is not zero, one after the other in the order in which a solution reads it.
//!
//! Half and more of the factors of a mechanism are zeros: axes that lie along those of the model, blocks that are diagonal. Where many
//! solutions follow one factorisation they are worth leaving out.

use std::ops::{Div, Mul};

use super::scalar::Scalar;
use super::step::Step;

/// The factors without their zeros.
#[derive(Clone, Debug, Default)]
pub(super) struct Packed<T> {
    /// Steps with something in L: their row, and where their entries end.
    forwards: Vec<(u32, u32)>,
    lower_rows: Vec<u32>,
    lower: Vec<T>,
    /// All steps from the last to the first: row, column, and where the entries of U end.
    backwards: Vec<(u32, u32, u32)>,
    pivots: Vec<T>,
    upper_columns: Vec<u32>,
    upper: Vec<T>,
}

impl<T: Scalar> Packed<T> {
    /// Takes them anew.
    pub(super) fn take(&mut self, steps: &[Step], index: &[u32], values: &[T]) {
        self.forwards.clear();
        self.lower_rows.clear();
        self.lower.clear();
        self.backwards.clear();
        self.pivots.clear();
        self.upper_columns.clear();
        self.upper.clear();
        let zero = T::default();
        for step in steps {
            let before = self.lower.len();
            for k in step.down().filter(|&k| values[k] != zero) {
                self.lower_rows.push(index[k]);
                self.lower.push(values[k]);
            }
            if self.lower.len() > before {
                self.forwards.push((step.row, self.lower.len() as u32));
            }
        }
        for step in steps.iter().rev() {
            for k in step.across().filter(|&k| values[k] != zero) {
                self.upper_columns.push(index[k]);
                self.upper.push(values[k]);
            }
            self.pivots.push(values[step.at as usize]);
            let end = self.upper.len() as u32;
            self.backwards.push((step.row, step.column, end));
        }
    }

    /// Solves for the right side `b`, which is used up; the solution goes to `x`, but for unknowns without a pivot.
    pub(super) fn solve_into<R>(&self, b: &mut [R], x: &mut [R])
    where
        R: Scalar + Mul<T, Output = R> + Div<T, Output = R>,
    {
        let mut from = 0;
        for &(row, end) in &self.forwards {
            let range = from..end as usize;
            from = range.end;
            let value = b[row as usize];
            if value == R::default() {
                continue;
            }
            let rows = &self.lower_rows[range.clone()];
            for (&row, &multiplier) in rows.iter().zip(&self.lower[range]) {
                b[row as usize] -= value * multiplier;
            }
        }
        let mut from = 0;
        for (&(row, column, end), &pivot) in self.backwards.iter().zip(&self.pivots) {
            let range = from..end as usize;
            from = range.end;
            let mut value = b[row as usize];
            let columns = &self.upper_columns[range.clone()];
            for (&column, &factor) in columns.iter().zip(&self.upper[range]) {
                value -= x[column as usize] * factor;
            }
            x[column as usize] = value / pivot;
        }
    }
}
