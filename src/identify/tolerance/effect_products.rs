//! Products of effect columns with the columns of a linear model, kept by variance class. From these, the model with any set of effects follows
//! at any variance components without another pass over the rows.

use nalgebra::{DMatrix, DVector};

use super::class::VarianceClass;
use super::columns::{Columns, RowsByVarianceClass};
use super::product::{gram, transposed};
use super::whitening::Whitening;

/// Products of effect columns `E` with the columns `A` and the residual `z` of a linear model. `W` holds the reciprocal variances of the rows.
pub struct EffectProducts {
    /// Number of columns of `A`, and number of columns of `E`.
    count: [usize; 2],
    shares: Vec<Share>,
}

/// Products over the rows of one variance class (rows of equal variance).
struct Share {
    class: VarianceClass,
    /// Indices of the columns of `A` that are nonzero in these rows.
    known: Vec<usize>,
    /// Nonzero columns of `E` in these rows.
    effects: Columns,
    /// Index in `effects` of each column of `E`; `None` if the column is zero in these rows.
    place: Vec<Option<usize>>,
    /// `A'E`, for the columns `known` and `effects.active`.
    cross: DMatrix<f64>,
    /// `E'z`, for the columns `effects.active`.
    gradient: Vec<f64>,
}

impl EffectProducts {
    /// Computes the products over whitened rows (see [`Whitening::apply`]). `residual` is reading minus prediction.
    pub fn new(
        whitening: &Whitening,
        jacobian: &RowsByVarianceClass,
        residual: &DVector<f64>,
        effects: RowsByVarianceClass,
    ) -> Self {
        let count = [jacobian.count, effects.count];
        let classes = whitening.classes.iter().zip(&whitening.rows_of);
        let columns = jacobian.classes.iter().zip(effects.classes);
        let shares = classes.zip(columns).map(|((class, rows), (A, E))| {
            let mut place = vec![None; count[1]];
            for (at, k) in E.active.iter().enumerate() {
                place[*k] = Some(at);
            }
            Share {
                class: class.clone(),
                known: A.active.clone(),
                place,
                cross: transposed(&A.values, &E.values),
                gradient: E.along(&residual.select_rows(rows)),
                effects: E,
            }
        });
        Self {
            count,
            shares: shares.collect(),
        }
    }

    /// Returns `A'W E` at the log standard deviations `ln`.
    pub fn cross(&self, ln: &[f64]) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(self.count[0], self.count[1]);
        for share in &self.shares {
            let weight = 1.0 / share.class.variance(ln);
            for (column, to) in share.cross.column_iter().zip(&share.effects.active) {
                for (value, row) in column.iter().zip(&share.known) {
                    out[(*row, *to)] += weight * value;
                }
            }
        }
        out
    }

    /// Returns `E'W z` at the log standard deviations `ln`.
    pub fn gradient(&self, ln: &[f64]) -> DVector<f64> {
        let mut out = DVector::zeros(self.count[1]);
        for share in &self.shares {
            let weight = 1.0 / share.class.variance(ln);
            for (value, to) in share.gradient.iter().zip(&share.effects.active) {
                out[*to] += weight * value;
            }
        }
        out
    }

    /// Returns column `k` of `E'W E` at the log standard deviations `ln`.
    pub fn gram_column(&self, ln: &[f64], k: usize) -> DVector<f64> {
        let mut out = DVector::zeros(self.count[1]);
        for share in &self.shares {
            let Some(at) = share.place[k] else { continue };
            let weight = 1.0 / share.class.variance(ln);
            let own = share
                .effects
                .values
                .tr_mul(&share.effects.values.column(at));
            for (value, to) in own.iter().zip(&share.effects.active) {
                out[*to] += weight * value;
            }
        }
        out
    }

    /// Returns the block of `E'W E` for these columns at the log standard deviations `ln`.
    pub fn gram_block(&self, ln: &[f64], columns: std::ops::Range<usize>) -> DMatrix<f64> {
        let n = columns.len();
        let mut out = DMatrix::zeros(n, n);
        for share in &self.shares {
            let weight = 1.0 / share.class.variance(ln);
            let place = |k: usize| share.place[columns.start + k];
            for i in 0..n {
                let Some(a) = place(i) else { continue };
                for j in 0..=i {
                    let Some(b) = place(j) else { continue };
                    let values = &share.effects.values;
                    out[(i, j)] += weight * values.column(a).dot(&values.column(b));
                    out[(j, i)] = out[(i, j)];
                }
            }
        }
        out
    }

    /// Returns the whole of `E'W E` at the log standard deviations `ln`; only its lower triangle is filled in.
    pub fn gram(&self, ln: &[f64]) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(self.count[1], self.count[1]);
        for share in &self.shares {
            let weight = 1.0 / share.class.variance(ln);
            let active = &share.effects.active;
            let own = gram(&share.effects.values);
            for (j, to) in active.iter().enumerate() {
                for (i, row) in active.iter().enumerate().skip(j) {
                    out[(*row, *to)] += weight * own[(i, j)];
                }
            }
        }
        out
    }
}
