//! Matrices of whitened rows, split by variance class.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::product::{gram, transposed};
use super::whitening::Whitening;
use crate::settings::ZERO_COLUMN_SHARE;

/// A matrix of whitened rows (see [`Whitening::apply`]), split into the rows of each variance class (rows of equal variance).
#[derive(Clone, Debug)]
pub struct RowsByVarianceClass {
    /// Number of columns of the whole matrix, including zero columns.
    pub(super) count: usize,
    /// Nonzero columns of the matrix, one entry per variance class.
    pub(super) classes: Vec<Columns>,
}

/// Nonzero columns of a matrix, restricted to the rows of one variance class.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    /// Indices of the nonzero columns in the whole matrix, in ascending order.
    pub active: Vec<usize>,
    /// Matrix entries: one row per row of the class, one column per entry of `active`.
    pub values: DMatrix<f64>,
}

impl RowsByVarianceClass {
    /// Splits the whitened matrix `turned` by the variance classes of `whitening`.
    pub fn new(whitening: &Whitening, turned: &DMatrix<f64>) -> Self {
        Self::of_rows(&whitening.rows_of, turned)
    }

    /// Splits the whitened matrix `turned`; `rows_of` lists the rows of each class.
    pub(super) fn of_rows(rows_of: &[Vec<usize>], turned: &DMatrix<f64>) -> Self {
        let height = turned.nrows();
        let column = |k: usize| &turned.as_slice()[k * height..(k + 1) * height];
        let all: Vec<&[f64]> = (0..turned.ncols()).map(column).collect();
        let nothing: Vec<f64> = all
            .iter()
            .map(|column| ZERO_COLUMN_SHARE * largest(column))
            .collect();
        let classes = rows_of.iter();
        Self {
            count: all.len(),
            classes: classes
                .map(|rows| Columns::new(rows, &all, &nothing))
                .collect(),
        }
    }
}

impl Columns {
    fn new(rows: &[usize], columns: &[&[f64]], nothing: &[f64]) -> Self {
        let count = rows.len();
        let mut active = Vec::with_capacity(columns.len());
        let mut values = Vec::with_capacity(count * columns.len());
        for (k, column) in columns.iter().enumerate() {
            let from = values.len();
            values.extend(rows.iter().map(|row| column[*row]));
            if largest(&values[from..]) <= nothing[k] {
                values.truncate(from);
            } else {
                active.push(k);
            }
        }
        Self {
            values: DMatrix::from_vec(count, active.len(), values),
            active,
        }
    }

    /// Returns a copy in which the columns listed in `changed` are replaced by the columns of `own`. `own.active` holds indices into `changed`.
    pub(super) fn replaced(&self, changed: &[usize], own: &Self) -> Self {
        let kept = self.active.iter().enumerate();
        let kept = kept.filter(|(_, k)| changed.binary_search(k).is_err());
        let kept = kept.map(|(at, k)| (*k, self.values.column(at)));
        let new = own.active.iter().enumerate();
        let new = new.map(|(at, k)| (changed[*k], own.values.column(at)));
        let mut all: Vec<_> = kept.chain(new).collect();
        all.sort_by_key(|(k, _)| *k);
        let mut values = DMatrix::zeros(self.values.nrows(), all.len());
        for (at, (_, column)) in all.iter().enumerate() {
            values.set_column(at, column);
        }
        Self {
            active: all.into_iter().map(|(k, _)| k).collect(),
            values,
        }
    }

    /// Computes the lower triangle of `A'A`, where `A` are these columns. The effect of a single load case is nonzero in a few successive rows
    /// only, and its products use only these rows.
    pub(super) fn gram(&self) -> DMatrix<f64> {
        let n = self.active.len();
        let extent = |k: usize| {
            let column = self.values.column(k);
            let first = column.iter().position(|x| *x != 0.0).unwrap_or(0);
            let end = column
                .iter()
                .rposition(|x| *x != 0.0)
                .map_or(first, |k| k + 1);
            first..end
        };
        let extents: Vec<Range<usize>> = (0..n).map(extent).collect();
        let is_long = |k: &usize| 4 * extents[*k].len() > self.values.nrows();
        let (long, short): (Vec<usize>, Vec<usize>) = (0..n).partition(is_long);
        if short.is_empty() {
            return gram(&self.values);
        }
        let mut out = DMatrix::zeros(n, n);
        let mut put = |i: usize, j: usize, value: f64| out[(i.max(j), i.min(j))] = value;
        let all = self.values.select_columns(&long);
        for (k, column) in gram(&all).column_iter().enumerate() {
            for (row, value) in column.iter().enumerate().skip(k) {
                put(long[row], long[k], *value);
            }
        }
        // Short columns that cover about the same rows are multiplied together.
        let mut ordered = short;
        ordered.sort_by_key(|k| (extents[*k].start, extents[*k].end));
        let mut from = 0;
        let mut groups: Vec<(Range<usize>, Vec<usize>)> = Vec::new();
        while from < ordered.len() {
            let mut rows = extents[ordered[from]].clone();
            let mut to = from + 1;
            while to < ordered.len() && extents[ordered[to]].start < rows.end {
                rows.end = rows.end.max(extents[ordered[to]].end);
                to += 1;
            }
            groups.push((rows, ordered[from..to].to_vec()));
            from = to;
        }
        for (rows, own) in groups {
            let here = self.values.rows(rows.start, rows.len());
            let part = here.select_columns(&own);
            let with_all = transposed(&all.rows(rows.start, rows.len()).into_owned(), &part);
            let among = gram(&part);
            for (j, to) in own.iter().enumerate() {
                for (i, row) in long.iter().enumerate() {
                    put(*row, *to, with_all[(i, j)]);
                }
                for (i, row) in own.iter().enumerate().skip(j) {
                    put(*row, *to, among[(i, j)]);
                }
            }
        }
        out
    }

    /// Computes `A'z`, where `A` are these columns.
    pub(super) fn along(&self, z: &DVector<f64>) -> Vec<f64> {
        self.values.tr_mul(z).as_slice().to_vec()
    }
}

/// Returns the largest magnitude in a column. The comparison runs in eight lanes, so the compiler can vectorise the loop.
fn largest(column: &[f64]) -> f64 {
    let mut lanes = [0.0_f64; 8];
    let blocks = column.chunks_exact(8);
    let rest = blocks.remainder().iter();
    for block in blocks {
        for (most, x) in lanes.iter_mut().zip(block) {
            *most = most.max(x.abs());
        }
    }
    rest.chain(&lanes).fold(0.0, |most, x| most.max(x.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_study::noise::Noise;

    #[test]
    fn products_of_short_columns_are_those_of_whole_ones() {
        let (rows, mut noise) = (60, Noise::new(4, "short columns"));
        let A = DMatrix::from_fn(rows, 12, |row, column| {
            let first = 6 * column;
            let is_short = column > 4;
            if is_short && !(first - 24..first - 16).contains(&row) {
                0.0
            } else {
                noise.normal()
            }
        });
        let columns = Columns {
            active: (0..12).collect(),
            values: A.clone(),
        };
        let expected = A.tr_mul(&A).lower_triangle();
        assert!((columns.gram() - expected).amax() < 1e-12);
    }
}
