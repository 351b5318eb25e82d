//! Sufficient statistics of one variance class of rows in a linear model: sums of squares and products.

use nalgebra::{DMatrix, DVector};

use super::class::VarianceClass;
use super::columns::Columns;
use super::product::{dot, transposed};

/// Gram matrices of the rows of one variance class (rows of equal variance). `A` denotes the derivatives of these rows with respect to the
/// unknowns, `z` their residuals.
#[derive(Clone, Debug)]
pub(super) struct ClassGram {
    /// Variance class of the rows.
    pub class: VarianceClass,
    /// Number of rows in the class.
    pub count: f64,
    /// Sum of squared residuals, `z'z`.
    pub q: f64,
    /// Active unknowns: indices of the unknowns on which these rows depend, in ascending order.
    active: Vec<usize>,
    /// Lower triangle of `A'A` over the active unknowns, column by column.
    H: Vec<f64>,
    /// `A'z` over the active unknowns.
    g: Vec<f64>,
}

/// Products of additional columns `E` with themselves, with `A` and with `z`, over the rows of one variance class.
pub(super) struct Block {
    /// Indices of the nonzero columns of `E` within their set.
    pub places: Vec<usize>,
    /// `E'A`, with one column for each unknown of the model.
    pub cross: DMatrix<f64>,
    /// Lower triangle of `E'E`.
    pub own: DMatrix<f64>,
    /// `E'z`.
    pub g: Vec<f64>,
}

impl ClassGram {
    /// Computes the products of the columns `A` and the residuals `z` over the rows of a class.
    pub(super) fn new(class: VarianceClass, A: &Columns, z: &DVector<f64>) -> Self {
        let full = A.gram();
        let n = A.active.len();
        let mut H = Vec::with_capacity(n * (n + 1) / 2);
        for k in 0..n {
            H.extend_from_slice(&full.as_slice()[k * n + k..(k + 1) * n]);
        }
        Self {
            class,
            count: z.len() as f64,
            q: z.norm_squared(),
            g: A.along(z),
            active: A.active.clone(),
            H,
        }
    }

    /// Returns the statistics of the model with additional columns. These become the unknowns `before`, `before + 1` and so on.
    pub(super) fn with(&self, before: usize, further: &Block) -> Self {
        let k = further.places.len();
        let (n, all) = (self.active.len(), self.active.len() + k);
        let mut H = Vec::with_capacity(all * (all + 1) / 2);
        let mut from = 0;
        for (at, unknown) in self.active.iter().enumerate() {
            H.extend_from_slice(&self.H[from..from + n - at]);
            from += n - at;
            H.extend((0..k).map(|row| further.cross[(row, *unknown)]));
        }
        for at in 0..k {
            H.extend((at..k).map(|row| further.own[(row, at)]));
        }
        let mut new = Self {
            H,
            active: self.active.clone(),
            g: self.g.clone(),
            class: self.class.clone(),
            ..*self
        };
        new.active.extend(further.places.iter().map(|k| before + k));
        new.g.extend_from_slice(&further.g);
        new
    }

    /// Returns the statistics of the model with new residuals `z` and with new values of the columns listed in `changed`. `own` holds the new
    /// columns that are not zero; `A` holds all columns, with old or new values of the changed ones.
    pub(super) fn moved(
        &self,
        A: &Columns,
        changed: &[usize],
        own: &Columns,
        z: &DVector<f64>,
    ) -> Self {
        let known: Vec<usize> = changed
            .iter()
            .filter_map(|unknown| self.active.binary_search(unknown).ok())
            .collect();
        let new = own.active.iter().map(|k| changed[*k]);
        if A.active != self.active || !new.eq(known.iter().map(|place| self.active[*place])) {
            // The rows depend on a different set of unknowns than before, so all products are computed again.
            return Self::new(self.class.clone(), &A.replaced(changed, own), z);
        }
        let mut cross = transposed(&A.values, &own.values);
        let among = transposed(&own.values, &own.values);
        let (mut g, own_g) = (A.along(z), own.along(z));
        for (k, place) in known.iter().enumerate() {
            g[*place] = own_g[k];
            cross.set_row(*place, &among.row(k));
        }
        let mut H = self.H.clone();
        let n = self.active.len();
        let start = |column: usize| column * (2 * n - column + 1) / 2;
        for (k, place) in known.iter().enumerate() {
            for (row, value) in cross.column(k).iter().enumerate() {
                let (low, high) = (row.min(*place), row.max(*place));
                H[start(low) + high - low] = *value;
            }
        }
        Self {
            q: z.norm_squared(),
            g,
            active: self.active.clone(),
            H,
            class: self.class.clone(),
            ..*self
        }
    }

    /// Returns the statistics without some of the rows; `rows` holds the statistics of these rows.
    pub(super) fn less(&self, rows: &Self) -> Self {
        let mut rest = self.clone();
        rest.count -= rows.count;
        rest.q -= rows.q;
        let n = self.active.len();
        let start = |column: usize| column * (2 * n - column + 1) / 2;
        let place = |unknown: &usize| self.active.binary_search(unknown).ok();
        let places: Vec<Option<usize>> = rows.active.iter().map(place).collect();
        for (k, (_, _, values)) in rows.columns().enumerate() {
            let Some(column) = places[k] else {
                continue;
            };
            rest.g[column] -= rows.g[k];
            for (row, value) in places[k..].iter().zip(values) {
                if let Some(row) = row {
                    rest.H[start(column) + row - column] -= value;
                }
            }
        }
        rest
    }

    /// Iterates over the columns of the stored triangle. Yields the unknown of the column, the unknowns of its rows, and the values.
    fn columns(&self) -> impl Iterator<Item = (usize, &[usize], &[f64])> {
        let n = self.active.len();
        let mut rest = self.H.as_slice();
        (0..n).map(move |k| {
            let (own, further) = rest.split_at(n - k);
            rest = further;
            (self.active[k], &self.active[k..], own)
        })
    }

    /// Adds `precision * A'A` to the lower triangle of `H` and `precision * A'z` to `g`. Both cover all unknowns.
    pub(super) fn add_to(&self, precision: f64, H: &mut DMatrix<f64>, g: &mut DVector<f64>) {
        let all = H.nrows();
        let is_dense = self.active.len() == all;
        for (unknown, rows, values) in self.columns() {
            let column = &mut H.as_mut_slice()[unknown * all..(unknown + 1) * all];
            if is_dense {
                for (sum, value) in column[unknown..].iter_mut().zip(values) {
                    *sum += precision * value;
                }
            } else {
                for (row, value) in rows.iter().zip(values) {
                    column[*row] += precision * value;
                }
            }
        }
        for (unknown, value) in self.active.iter().zip(&self.g) {
            g[*unknown] += precision * value;
        }
    }

    /// Returns the trace of the product of `A'A` with a symmetric matrix. `doubled` holds the lower triangle of that matrix with its
    /// off-diagonal entries doubled.
    pub(super) fn product(&self, doubled: &DMatrix<f64>) -> f64 {
        let all = doubled.nrows();
        let is_dense = self.active.len() == all;
        let mut sum = 0.0;
        for (unknown, rows, values) in self.columns() {
            let column = &doubled.as_slice()[unknown * all..(unknown + 1) * all];
            sum += if is_dense {
                dot(&column[unknown..], values)
            } else {
                let pairs = rows.iter().zip(values);
                pairs.map(|(row, value)| column[*row] * value).sum::<f64>()
            };
        }
        sum
    }

    /// Computes `|z - A s|^2`, the sum of squared residuals of the linear model after a step `s`.
    pub(super) fn left(&self, step: &DVector<f64>) -> f64 {
        let own: Vec<f64> = self.active.iter().map(|unknown| step[*unknown]).collect();
        let mut curved = 0.0;
        for (k, (_, _, values)) in self.columns().enumerate() {
            curved += own[k] * (2.0 * dot(&own[k + 1..], &values[1..]) + own[k] * values[0]);
        }
        self.q - 2.0 * dot(&own, &self.g) + curved
    }
}
