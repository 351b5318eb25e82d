//! Pattern of the LU factors found by a first elimination, and factorisations of further matrices with this pattern.
//!
//! A further factorisation goes row by row: each row subtracts multiples of the rows above it. No list of operations is stored. The row is
//! scattered into a dense vector over all columns, and the column indices of U determine where the products go. Zeros, which are numerous, are
//! neither stored nor subtracted. Each entry receives its products in the order of the elimination steps, as in the first elimination, which
//! chose the pivots.

use super::entries::Entries;
use super::factors::Factors;
use super::pivoting::Eliminated;
use super::scalar::Scalar;
use super::step::{EliminationStep, Pivot, Scales};

const NOWHERE: u32 = u32::MAX;

/// An elimination step, and the ends of its row in the lists of the pattern.
#[derive(Clone, Copy, Debug)]
struct PivotRow {
    step: EliminationStep,
    entries: u32,
    lower: u32,
    upper: u32,
}

/// Steps of an elimination, and the positions at which the factors may be nonzero.
#[derive(Clone, Debug, Default)]
pub(super) struct Pattern {
    rows: Vec<PivotRow>,
    /// (index, column) of the entries of the matrix, grouped by elimination step.
    entries: Vec<(u32, u32)>,
    /// Entries of L, grouped by elimination step: the earlier step whose row is subtracted, and the pivot column of that step.
    lower: Vec<(u32, u32)>,
    /// Columns of the entries of U, grouped by elimination step.
    upper: Vec<u32>,
}

/// Work space of a factorisation.
#[derive(Clone, Debug, Default)]
pub(super) struct Spread<T> {
    /// The current row, scattered over all columns. All its entries are zero between two rows, and it is empty after an aborted factorisation.
    row: Vec<T>,
    pivots: Vec<Pivot<T>>,
}

impl Pattern {
    /// Returns the pattern and the factors of a completed elimination of the matrix.
    pub(super) fn of<T: Scalar>(
        done: &Eliminated<T>,
        matrix: &Entries<'_, T>,
    ) -> (Self, Factors<T>) {
        let count = done.steps.len();
        // Rows without a pivot have no elimination step.
        let mut step_of = vec![NOWHERE; matrix.n];
        for (k, step) in done.steps.iter().enumerate() {
            step_of[step.row as usize] = k as u32;
        }
        let places = matrix.places.iter().enumerate();
        let (entry_ends, entries) = by_rows(count, || {
            let rows = places.clone();
            rows.map(|(k, &(column, row))| (step_of[row as usize], (k as u32, column)))
        });
        let (lower_ends, left) = by_rows(count, || {
            let of_step = |k: usize| done.of_step(k).1.iter().map(move |entry| (k, entry));
            let all = (0..count).flat_map(of_step);
            all.map(|(k, &(row, at))| (step_of[row as usize], (k as u32, at)))
        });
        let mut pattern = Self {
            rows: Vec::with_capacity(count),
            entries,
            lower: (left.iter())
                .map(|(k, _)| (*k, done.steps[*k as usize].column))
                .collect(),
            upper: Vec::new(),
        };
        let across = (0..count).flat_map(|k| done.of_step(k).0);
        pattern.upper.extend(across.map(|(column, _)| *column));
        let mut factors = Factors::default();
        let mut to = factors.begin(pattern.lower.len(), pattern.upper.len());
        let (mut from, mut upper) = (0, 0);
        for (k, &step) in done.steps.iter().enumerate() {
            let lower = lower_ends[k];
            for &(k, at) in &left[from as usize..lower as usize] {
                let multiplier = done.values[at as usize];
                if multiplier != T::default() {
                    to.push_lower(done.steps[k as usize].row, multiplier);
                }
            }
            from = lower;
            let across = done.of_step(k).0;
            for &(column, at) in across {
                to.push_upper(column, done.values[at as usize]);
            }
            upper += across.len() as u32;
            to.end_row(step.row, step.column, done.values[done.pivots[k] as usize]);
            pattern.rows.push(PivotRow {
                step,
                entries: entry_ends[k],
                lower,
                upper,
            });
        }
        (pattern, factors)
    }

    /// Returns the number of entries in the factors.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.rows.len() + self.lower.len() + self.upper.len()
    }

    /// Factors another matrix of the same pattern. Returns false if a pivot has become too small, judged by the scales of the rows and columns
    /// and by the allowed `growth`.
    pub(super) fn fill<T: Scalar>(
        &self,
        matrix: &Entries<'_, T>,
        scales: Scales<'_>,
        growth: f64,
        spread: &mut Spread<T>,
        factors: &mut Factors<T>,
    ) -> bool {
        let Spread { row, pivots } = spread;
        row.resize(matrix.n, T::default());
        pivots.clear();
        let done = self.run(matrix, scales, growth, (row, pivots), factors);
        if !done {
            row.clear();
        }
        done
    }

    fn run<T: Scalar>(
        &self,
        matrix: &Entries<'_, T>,
        scales: Scales<'_>,
        growth: f64,
        (row, pivots): (&mut [T], &mut Vec<Pivot<T>>),
        factors: &mut Factors<T>,
    ) -> bool {
        let zero = T::default();
        let mut to = factors.begin(self.lower.len(), self.upper.len());
        let (mut entry, mut lower, mut upper) = (0, 0, 0);
        for ends in &self.rows {
            let step = &ends.step;
            for &(k, column) in &self.entries[entry..ends.entries as usize] {
                row[column as usize] = matrix.values[k as usize];
            }
            let row_scale = scales.row[step.row as usize];
            for &(k, column) in &self.lower[lower..ends.lower as usize] {
                let value = std::mem::take(&mut row[column as usize]);
                if value == zero {
                    continue;
                }
                let pivot = &pivots[k as usize];
                if !pivot.is_acceptable(value, row_scale) {
                    return false;
                }
                let multiplier = value * pivot.inverse;
                let (columns, factors) = to.upper(k as usize);
                for (&column, &factor) in columns.iter().zip(factors) {
                    row[column as usize] -= multiplier * factor;
                }
                to.push_lower(self.rows[k as usize].step.row, multiplier);
            }
            for &column in &self.upper[upper..ends.upper as usize] {
                to.push_upper(column, std::mem::take(&mut row[column as usize]));
            }
            let value = std::mem::take(&mut row[step.column as usize]);
            to.end_row(step.row, step.column, value);
            let column_scale = scales.column[step.column as usize];
            let Some(pivot) = step.pivot(value, row_scale, column_scale, growth) else {
                return false;
            };
            pivots.push(pivot);
            (entry, lower, upper) = (
                ends.entries as usize,
                ends.lower as usize,
                ends.upper as usize,
            );
        }
        true
    }
}

/// Groups (row, item) pairs by row. Within a row, the items keep their order of arrival. Pairs whose row is [`NOWHERE`] are omitted. `count` is
/// the number of rows. Returns the end of each row in the grouped list, and the list.
fn by_rows<I>(count: usize, items: impl Fn() -> I) -> (Vec<u32>, Vec<(u32, u32)>)
where
    I: Iterator<Item = (u32, (u32, u32))>,
{
    let of_rows = || items().filter(|(row, _)| *row != NOWHERE);
    let mut next = vec![0_u32; count + 1];
    for (row, _) in of_rows() {
        next[row as usize + 1] += 1;
    }
    for k in 0..count {
        next[k + 1] += next[k];
    }
    let mut sorted = vec![(0, 0); next[count] as usize];
    for (row, item) in of_rows() {
        let at = &mut next[row as usize];
        sorted[*at as usize] = item;
        *at += 1;
    }
    // Each entry of `next` has advanced to the end of its row.
    next.pop();
    (next, sorted)
}
