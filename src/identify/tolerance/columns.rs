//! Matrices of whitened rows, split by variance class.

use nalgebra::{DMatrix, DVector};

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
