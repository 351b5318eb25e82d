//! Columns that a linear model does not have yet, and their products with its own: what each would gain takes no other look at the rows.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::columns::{ByClass, Columns};
use super::product::{gram, transposed};
use super::share::Block;
use super::whitening::{Class, Whitening};

/// Further columns `E` beside the columns `A` of a linear model with the residual `z`.
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
    /// Those of `E`.
    E: Columns,
    /// `A'E` of both.
    cross: DMatrix<f64>,
    /// `E'z`.
    g: DVector<f64>,
}

impl Further {
    /// Of turned rows: the columns of the model, its residual (reading minus prediction), and the further columns.
    pub(crate) fn new(
        whitening: &Whitening,
        (jacobian, residual): (&ByClass, &DVector<f64>),
        further: ByClass,
    ) -> Self {
        let count = [jacobian.count, further.count];
        let classes = whitening.classes.iter().zip(&whitening.rows_of);
        let columns = jacobian.classes.iter().zip(further.classes);
        let shares = classes
            .zip(columns)
            .map(|((class, rows), (A, E))| FurtherShare {
                class: *class,
                cross: transposed(&A.values, &E.values),
                g: E.values.tr_mul(&residual.select_rows(rows)),
                known: A.active.clone(),
                E,
            });
        Self {
            shares: shares.collect(),
            count,
        }
    }

    /// `A'W E` at these sizes, and `E'W (z - A s)` after a step `s`.
    pub(crate) fn at(&self, ln: &[f64], step: &DVector<f64>) -> (DMatrix<f64>, DVector<f64>) {
        let [n, m] = self.count;
        let (mut cross, mut g) = (DMatrix::<f64>::zeros(n, m), DVector::zeros(m));
        for share in &self.shares {
            let precision = 1.0 / share.class.variance(ln);
            for (k, column) in share.E.active.iter().enumerate() {
                g[*column] += precision * share.g[k];
                let to = &mut cross.as_mut_slice()[column * n..(column + 1) * n];
                let from = share.cross.column(k);
                if share.known.len() == n {
                    for (sum, value) in to.iter_mut().zip(from.iter()) {
                        *sum += precision * value;
                    }
                } else {
                    for (unknown, value) in share.known.iter().zip(from.iter()) {
                        to[*unknown] += precision * value;
                    }
                }
            }
        }
        g -= cross.tr_mul(step);
        (cross, g)
    }

    /// `E'W E` of some columns at these sizes.
    pub(crate) fn own(&self, range: &Range<usize>, ln: &[f64]) -> DMatrix<f64> {
        let k = range.len();
        let mut out = DMatrix::zeros(k, k);
        for share in &self.shares {
            let precision = 1.0 / share.class.variance(ln);
            let active = &share.E.active;
            let first = active.partition_point(|column| *column < range.start);
            let end = active.partition_point(|column| *column < range.end);
            for a in first..end {
                for b in first..=a {
                    let product = share.E.values.column(a).dot(&share.E.values.column(b));
                    let (row, column) = (active[a] - range.start, active[b] - range.start);
                    out[(row, column)] += precision * product;
                    if row != column {
                        out[(column, row)] += precision * product;
                    }
                }
            }
        }
        out
    }

    /// Some columns, class by class.
    pub(super) fn blocks(&self, range: &Range<usize>) -> impl Iterator<Item = Block> {
        self.shares.iter().map(move |share| {
            let active = &share.E.active;
            let first = active.partition_point(|column| *column < range.start);
            let end = active.partition_point(|column| *column < range.end);
            let mut cross = DMatrix::zeros(end - first, self.count[0]);
            for (k, unknown) in share.known.iter().enumerate() {
                for at in first..end {
                    cross[(at - first, *unknown)] = share.cross[(k, at)];
                }
            }
            let E = share.E.values.columns(first, end - first).into_owned();
            Block {
                places: active[first..end].iter().map(|c| c - range.start).collect(),
                cross,
                own: gram(&E),
                g: share.g.as_slice()[first..end].to_vec(),
            }
        })
    }
}
