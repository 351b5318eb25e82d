//! The pattern of LU factors that an elimination has found, and eliminations that fill it with other values.
//!
//! They go row after row, each taking off what the rows above it contribute. No list of operations is kept: a row is spread out over all
//! columns, and what stands in the rows of U says where the products go. Zeros, of which there are many, are neither stored nor taken off.
//! Each entry gets its products in the order of the steps, as in the elimination that chose them.

use super::entries::Entries;
use super::factors::Factors;
use super::scalar::Scalar;
use super::step::{Pivot, Step};

/// The steps of an elimination with the places that may not be zero.
#[derive(Clone, Debug, Default)]
pub(super) struct Pattern {
    pub steps: Vec<Step>,
    /// Entries of the matrix with their columns, by the rows of the steps.
    pub entries: Vec<(u32, u32)>,
    /// Steps that stand in L with their columns, in their order.
    pub lower: Vec<(u32, u32)>,
    /// Columns that stand in U.
    pub upper: Vec<u32>,
}

/// Memory of an elimination.
#[derive(Clone, Debug, Default)]
pub(super) struct Spread<T> {
    /// A row spread out over all columns; zero between two rows, empty after an elimination that ended early.
    row: Vec<T>,
    pivots: Vec<Pivot<T>>,
}

impl Pattern {
    /// How many places the factors have.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.steps.len() + self.lower.len() + self.upper.len()
    }

    /// Factors of a matrix; false if a pivot has shrunk too far, by the scales of rows and columns and the growth that is allowed.
    pub(super) fn fill<T: Scalar>(
        &self,
        matrix: &Entries<'_, T>,
        (row_scale, column_scale): (&[f64], &[f64]),
        growth: f64,
        spread: &mut Spread<T>,
        factors: &mut Factors<T>,
    ) -> bool {
        let Spread { row, pivots } = spread;
        row.resize(matrix.n, T::default());
        pivots.clear();
        let done = self.run(
            matrix,
            (row_scale, column_scale),
            growth,
            (row, pivots),
            factors,
        );
        if !done {
            row.clear();
        }
        done
    }

    fn run<T: Scalar>(
        &self,
        matrix: &Entries<'_, T>,
        (row_scale, column_scale): (&[f64], &[f64]),
        growth: f64,
        (row, pivots): (&mut [T], &mut Vec<Pivot<T>>),
        factors: &mut Factors<T>,
    ) -> bool {
        let zero = T::default();
        let mut to = factors.begin(self.lower.len(), self.upper.len());
        let (mut entry, mut lower, mut upper) = (0, 0, 0);
        for step in &self.steps {
            for &(k, column) in &self.entries[entry..step.entries as usize] {
                row[column as usize] = matrix.values[k as usize];
            }
            let scale = row_scale[step.row as usize];
            for &(k, column) in &self.lower[lower..step.lower as usize] {
                let value = std::mem::take(&mut row[column as usize]);
                if value == zero {
                    continue;
                }
                let pivot = &pivots[k as usize];
                if !pivot.serves(value, scale) {
                    return false;
                }
                let multiplier = value * pivot.inverse;
                let (columns, factors) = to.upper(k as usize);
                for (&column, &factor) in columns.iter().zip(factors) {
                    row[column as usize] -= multiplier * factor;
                }
                to.push_lower(self.steps[k as usize].row, multiplier);
            }
            for &column in &self.upper[upper..step.upper as usize] {
                to.push_upper(column, std::mem::take(&mut row[column as usize]));
            }
            let value = std::mem::take(&mut row[step.column as usize]);
            to.end_row(step.row, step.column, value);
            let scales = (scale, column_scale[step.column as usize]);
            let Some(pivot) = step.pivot(value, scales, growth) else {
                return false;
            };
            pivots.push(pivot);
            (entry, lower, upper) = (
                step.entries as usize,
                step.lower as usize,
                step.upper as usize,
            );
        }
        true
    }
}
