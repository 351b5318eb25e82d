//! Columns that a linear model does not have yet, and their products with its own: what each would gain takes no other look at the rows.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::columns::{ByClass, Columns};
use super::product::{gram, transposed};
use super::share::Block;
use super::whitening::{Class, Whitening};

/// So many columns are looked at together: few enough to stay in a processor's cache.
const TOGETHER: usize = 64;

/// Further columns `E`, in sets, beside the columns `A` of a linear model with the residual `z`.
pub(crate) struct Further {
    /// How many columns each of the two has.
    count: [usize; 2],
    shares: Vec<FurtherShare>,
}

/// The rows of one class.
struct FurtherShare {
    class: Class,
    /// Columns of `A` that these rows depend on.
    known: Vec<usize>,
    /// Those of `E`, set by set.
    sets: Vec<Set>,
}

/// A set of columns of `E` in the rows of one class.
struct Set {
    /// The first of them.
    first: usize,
    /// Those that these rows depend on, counted from the first.
    active: Vec<usize>,
    /// `A'E` of those and the known ones, column by column.
    cross: Vec<f64>,
    /// `E'z` of those.
    g: Vec<f64>,
    /// `E'E` of those, its lower triangle.
    own: DMatrix<f64>,
}

impl Further {
    /// Of turned rows: the columns of the model, its residual (reading minus prediction), and sets of further columns that follow one
    /// another, with what gives those of a range; it is asked once for each, in order.
    pub(crate) fn new(
        whitening: &Whitening,
        (jacobian, residual): (&ByClass, &DVector<f64>),
        (sets, mut turned): (&[Range<usize>], impl FnMut(Range<usize>) -> DMatrix<f64>),
    ) -> Self {
        let classes = whitening.classes.iter().zip(&jacobian.classes);
        let share = |(class, A): (&Class, &Columns)| FurtherShare {
            class: *class,
            known: A.active.clone(),
            sets: Vec::with_capacity(sets.len()),
        };
        let mut shares: Vec<FurtherShare> = classes.map(share).collect();
        let rows = whitening.rows_of.iter();
        let z: Vec<DVector<f64>> = rows.map(|rows| residual.select_rows(rows)).collect();
        let mut rest = sets;
        while let Some(first) = rest.first() {
            let fits = |set: &&Range<usize>| set.end <= first.start + TOGETHER;
            let count = rest.iter().take_while(fits).count().max(1);
            let (here, after) = rest.split_at(count);
            rest = after;
            let from = first.start;
            let to = here.last().map_or(from, |last| last.end);
            let E = ByClass::new(whitening, &turned(from..to));
            for (k, share) in shares.iter_mut().enumerate() {
                let (A, E) = (&jacobian.classes[k], &E.classes[k]);
                let cross = transposed(&A.values, &E.values);
                let g = E.along(&z[k]);
                let set = |set: &Range<usize>| Set::new(E, (&cross, &g), set, from);
                share.sets.extend(here.iter().map(set));
            }
        }
        Self {
            count: [jacobian.count, sets.last().map_or(0, |set| set.end)],
            shares,
        }
    }

    /// `A'W E` at these sizes, and `E'W (z - A s)` after a step `s`.
    pub(crate) fn at(&self, ln: &[f64], step: &DVector<f64>) -> (DMatrix<f64>, DVector<f64>) {
        let [n, m] = self.count;
        let (mut cross, mut g) = (DMatrix::<f64>::zeros(n, m), DVector::zeros(m));
        for share in &self.shares {
            let precision = 1.0 / share.class.variance(ln);
            let is_dense = share.known.len() == n;
            for set in &share.sets {
                let columns = set.cross.chunks_exact(share.known.len().max(1));
                for ((at, own), from) in set.active.iter().zip(&set.g).zip(columns) {
                    let column = set.first + at;
                    g[column] += precision * own;
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
        }
        g -= cross.tr_mul(step);
        (cross, g)
    }

    /// `E'W E` of a set of `count` columns at these sizes.
    pub(crate) fn own(&self, set: usize, count: usize, ln: &[f64]) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(count, count);
        for share in &self.shares {
            let precision = 1.0 / share.class.variance(ln);
            let set = &share.sets[set];
            for (a, row) in set.active.iter().enumerate() {
                for (b, column) in set.active[..=a].iter().enumerate() {
                    let value = precision * set.own[(a, b)];
                    out[(*row, *column)] += value;
                    if row != column {
                        out[(*column, *row)] += value;
                    }
                }
            }
        }
        out
    }

    /// A set of columns, class by class.
    pub(super) fn blocks(&self, set: usize) -> impl Iterator<Item = Block> {
        self.shares.iter().map(move |share| {
            let set = &share.sets[set];
            let count = set.active.len();
            let mut cross = DMatrix::zeros(count, self.count[0]);
            let columns = set.cross.chunks_exact(share.known.len().max(1));
            for (at, column) in columns.enumerate() {
                for (unknown, value) in share.known.iter().zip(column) {
                    cross[(at, *unknown)] = *value;
                }
            }
            Block {
                places: set.active.clone(),
                cross,
                own: set.own.clone(),
                g: set.g.clone(),
            }
        })
    }
}

impl Set {
    /// Of columns `E` from `from` on and their products.
    fn new(
        E: &Columns,
        (cross, g): (&DMatrix<f64>, &[f64]),
        set: &Range<usize>,
        from: usize,
    ) -> Self {
        let place = |column: usize| E.active.partition_point(|k| from + k < column);
        let (first, end) = (place(set.start), place(set.end));
        let known = cross.nrows();
        Self {
            first: set.start,
            active: E.active[first..end]
                .iter()
                .map(|k| from + k - set.start)
                .collect(),
            cross: cross.as_slice()[first * known..end * known].to_vec(),
            g: g[first..end].to_vec(),
            own: gram(&E.values.columns(first, end - first).into_owned()),
        }
    }
}
