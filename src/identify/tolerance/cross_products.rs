//! Products of candidate columns with the columns of a linear model. From these, the gain of appending a candidate follows without another pass
//! over the rows.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::class::VarianceClass;
use super::class_gram::Block;
use super::columns::{Columns, RowsByVarianceClass};
use super::product::{dot, transposed};
use super::whitening::Whitening;
use crate::settings::COLUMN_BLOCK;

/// Products of candidate columns `E`, grouped in sets, with the columns `A` and the residuals `z` of a linear model.
pub struct CrossProducts {
    /// Number of columns of `A`, and number of columns of `E`.
    count: [usize; 2],
    shares: Vec<FurtherShare>,
}

/// Products over the rows of one variance class (rows of equal variance).
struct FurtherShare {
    class: VarianceClass,
    /// Indices of the columns of `A` that are nonzero in these rows.
    known: Vec<usize>,
    /// Locations of the sets of candidate columns.
    sets: Vec<Set>,
    /// Indices of the columns of `E` that are nonzero in these rows, set by set.
    active: Vec<usize>,
    /// `A'E` for the columns `known` of `A` and the columns `active` of `E`, stored column by column.
    cross: Vec<f64>,
    /// `E'z` for the columns `active` of `E`.
    g: Vec<f64>,
    /// `E'E` of each set, stored as the rows of its lower triangle.
    own: Vec<f64>,
}

/// Location of one set within a [`FurtherShare`].
struct Set {
    /// Index of the first column of the set among all columns of `E`.
    first: usize,
    /// Range of the entries of `active` that belong to the set.
    active: Range<usize>,
    /// Index in `own` at which the `E'E` of the set starts.
    own: usize,
}

impl CrossProducts {
    /// Computes all products over the whitened rows. `residual` is reading minus prediction; `sets` are consecutive ranges of candidate
    /// columns.
    ///
    /// `turned` returns the whitened candidate columns of a range. It is called with consecutive ranges that together cover each column once.
    pub fn new(
        whitening: &Whitening,
        jacobian: &RowsByVarianceClass,
        residual: &DVector<f64>,
        sets: &[Range<usize>],
        mut turned: impl FnMut(Range<usize>) -> DMatrix<f64>,
    ) -> Self {
        let classes = whitening.classes.iter().zip(&jacobian.classes);
        let share = |(class, A): (&VarianceClass, &Columns)| FurtherShare {
            class: class.clone(),
            known: A.active.clone(),
            sets: Vec::with_capacity(sets.len()),
            active: Vec::new(),
            cross: Vec::new(),
            g: Vec::new(),
            own: Vec::new(),
        };
        let mut shares: Vec<FurtherShare> = classes.map(share).collect();
        let rows = whitening.rows_of.iter();
        let z: Vec<DVector<f64>> = rows.map(|rows| residual.select_rows(rows)).collect();
        let mut rest = sets;
        while let Some(first) = rest.first() {
            let fits = |set: &&Range<usize>| set.end <= first.start + COLUMN_BLOCK;
            let count = rest.iter().take_while(fits).count().max(1);
            let (here, after) = rest.split_at(count);
            rest = after;
            let from = first.start;
            let to = here.last().map_or(from, |last| last.end);
            let E = RowsByVarianceClass::new(whitening, &turned(from..to));
            for (k, share) in shares.iter_mut().enumerate() {
                let (A, E) = (&jacobian.classes[k], &E.classes[k]);
                let cross = transposed(&A.values, &E.values);
                let before = share.active.len();
                share.active.extend(E.active.iter().map(|k| from + k));
                share.cross.extend_from_slice(cross.as_slice());
                share.g.extend(E.along(&z[k]));
                for set in here {
                    share.add(set, E, before);
                }
            }
        }
        Self {
            count: [jacobian.count, sets.last().map_or(0, |set| set.end)],
            shares,
        }
    }

    /// Returns `A'W E` and `E'W (z - A s)`. `W` holds the precisions of the rows at the log standard deviations `ln`, and `s` is a step of the
    /// unknowns.
    pub fn at(&self, ln: &[f64], step: &DVector<f64>) -> (DMatrix<f64>, DVector<f64>) {
        let [n, m] = self.count;
        let (mut cross, mut g) = (DMatrix::<f64>::zeros(n, m), DVector::zeros(m));
        for share in &self.shares {
            let precision = 1.0 / share.class.variance(ln);
            let is_dense = share.known.len() == n;
            let columns = share.cross.chunks_exact(share.known.len().max(1));
            for (column, own) in share.active.iter().zip(&share.g) {
                g[*column] += precision * own;
            }
            for (column, from) in share.active.iter().zip(columns) {
                let to = &mut cross.as_mut_slice()[column * n..(column + 1) * n];
                if is_dense {
                    for (sum, value) in to.iter_mut().zip(from) {
                        *sum += precision * value;
                    }
                } else {
                    for (unknown, value) in share.known.iter().zip(from) {
                        to[*unknown] += precision * value;
                    }
                }
            }
        }
        g -= cross.tr_mul(step);
        (cross, g)
    }

    /// Returns `E'W E` of a set of `count` candidate columns. `W` holds the precisions of the rows at the log standard deviations `ln`.
    pub fn own(&self, set: usize, count: usize, ln: &[f64]) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(count, count);
        for share in &self.shares {
            let precision = 1.0 / share.class.variance(ln);
            let set = &share.sets[set];
            let mut own = share.own[set.own..].iter();
            let active = &share.active[set.active.clone()];
            for (a, row) in active.iter().enumerate() {
                for (column, value) in active[..=a].iter().zip(&mut own) {
                    let (row, column) = (row - set.first, column - set.first);
                    out[(row, column)] += precision * value;
                    if row != column {
                        out[(column, row)] += precision * value;
                    }
                }
            }
        }
        out
    }

    /// Returns the products of a set of candidate columns, one block per variance class (rows of equal variance).
    pub(super) fn blocks(&self, set: usize) -> impl Iterator<Item = Block> {
        self.shares.iter().map(move |share| {
            let set = &share.sets[set];
            let range = set.active.clone();
            let mut cross = DMatrix::zeros(range.len(), self.count[0]);
            let columns = share.cross.chunks_exact(share.known.len().max(1));
            for (at, column) in columns.skip(range.start).take(range.len()).enumerate() {
                for (unknown, value) in share.known.iter().zip(column) {
                    cross[(at, *unknown)] = *value;
                }
            }
            let mut triangle = share.own[set.own..].iter();
            let mut own = DMatrix::zeros(range.len(), range.len());
            for a in 0..range.len() {
                for (b, value) in (0..=a).zip(&mut triangle) {
                    own[(a, b)] = *value;
                }
            }
            Block {
                places: share.active[range.clone()]
                    .iter()
                    .map(|k| k - set.first)
                    .collect(),
                cross,
                own,
                g: share.g[range].to_vec(),
            }
        })
    }
}

impl FurtherShare {
    /// Adds the products `E'E` of a set of candidate columns and its location. The nonzero columns of the set are among the entries of
    /// `active` from index `before` on.
    fn add(&mut self, set: &Range<usize>, E: &Columns, before: usize) {
        let place = |column: usize| self.active[before..].partition_point(|k| *k < column);
        let here = place(set.start)..place(set.end);
        let own = self.own.len();
        let height = E.values.nrows();
        let column = |k: usize| &E.values.as_slice()[k * height..(k + 1) * height];
        for a in here.clone() {
            for b in here.start..=a {
                self.own.push(dot(column(a), column(b)));
            }
        }
        self.sets.push(Set {
            first: set.start,
            active: before + here.start..before + here.end,
            own,
        });
    }
}
