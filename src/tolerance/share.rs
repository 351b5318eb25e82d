//! What a linear model needs of the rows of one class: sums of squares and products.

use nalgebra::{DMatrix, DVector};

use super::product::{gram, transposed};
use super::whitening::Class;

/// A column whose entries in the rows of a class stay below this part of its largest is zero there: marks of one part that move as one
/// body leave rounding in the rows that say how they move against each other.
const NOTHING: f64 = 1e-12;

/// Rows of one class: of `A`, the derivatives by the unknowns, and `z`, what is left.
#[derive(Clone, Debug)]
pub(super) struct Share {
    /// The class.
    pub class: Class,
    /// How many rows.
    pub count: f64,
    /// `z'z`.
    pub q: f64,
    /// Unknowns that these rows depend on, in ascending order.
    active: Vec<usize>,
    /// `A'A` of those, the lower triangle column by column.
    H: Vec<f64>,
    /// `A'z` of those.
    g: Vec<f64>,
}

/// Columns of a matrix in the rows of a class, those without anything left out.
pub(super) struct Columns {
    /// Which columns they are, in ascending order.
    pub active: Vec<usize>,
    /// Their values.
    pub values: DMatrix<f64>,
}

impl Columns {
    /// `largest` is the largest entry of each column, in all rows.
    pub(super) fn new<'a>(
        rows: &[usize],
        columns: impl Iterator<Item = &'a [f64]>,
        largest: &[f64],
    ) -> Self {
        let count = rows.len();
        let mut active = Vec::with_capacity(largest.len());
        let mut values = Vec::with_capacity(count * largest.len());
        for (k, column) in columns.enumerate() {
            let from = values.len();
            values.extend(rows.iter().map(|row| column[*row]));
            let nothing = NOTHING * largest[k];
            if values[from..].iter().all(|value| value.abs() <= nothing) {
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
}

/// Some further columns `E` in the rows of one class.
pub(super) struct Block {
    /// Places of columns within the range asked for; the others are zero in these rows.
    pub places: Vec<usize>,
    /// `E'A` by all unknowns of the model.
    pub cross: DMatrix<f64>,
    /// `E'E`, its lower triangle.
    pub own: DMatrix<f64>,
    /// `E'z`.
    pub g: Vec<f64>,
}

/// Columns of a matrix.
pub(super) fn columns_of(matrix: &DMatrix<f64>) -> impl Iterator<Item = &[f64]> {
    let height = matrix.nrows();
    (0..matrix.ncols()).map(move |k| &matrix.as_slice()[k * height..(k + 1) * height])
}

/// The largest entry of each column.
pub(super) fn largest(matrix: &DMatrix<f64>) -> Vec<f64> {
    let most = |column: &[f64]| column.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    columns_of(matrix).map(most).collect()
}

impl Share {
    /// Of the columns and the residual in the rows of a class.
    pub(super) fn new(class: Class, A: &Columns, z: &DVector<f64>) -> Self {
        let full = gram(&A.values);
        let n = A.active.len();
        let mut H = Vec::with_capacity(n * (n + 1) / 2);
        for k in 0..n {
            H.extend_from_slice(&full.as_slice()[k * n + k..(k + 1) * n]);
        }
        Self {
            class,
            count: z.len() as f64,
            q: z.norm_squared(),
            g: A.values.tr_mul(z).as_slice().to_vec(),
            active: A.active.clone(),
            H,
        }
    }

    /// With further columns, which become unknowns from `before` on.
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
            ..*self
        };
        new.active.extend(further.places.iter().map(|k| before + k));
        new.g.extend_from_slice(&further.g);
        new
    }

    /// With other values of the columns `changed` of `A`, and another residual. `None` where the rows depend on other unknowns than before.
    pub(super) fn moved(&self, A: &Columns, changed: &[usize], z: &DVector<f64>) -> Option<Self> {
        if A.active != self.active {
            return None;
        }
        let places: Vec<usize> = changed
            .iter()
            .filter_map(|unknown| A.active.binary_search(unknown).ok())
            .collect();
        let own = A.values.select_columns(&places);
        let cross = transposed(&A.values, &own);
        let mut H = self.H.clone();
        let n = self.active.len();
        let start = |column: usize| column * (2 * n - column + 1) / 2;
        for (k, place) in places.iter().enumerate() {
            let column = cross.column(k);
            for row in 0..n {
                let (low, high) = (row.min(*place), row.max(*place));
                H[start(low) + high - low] = column[row];
            }
        }
        Some(Self {
            class: self.class,
            count: self.count,
            q: z.norm_squared(),
            g: A.values.tr_mul(z).as_slice().to_vec(),
            active: self.active.clone(),
            H,
        })
    }

    /// Columns of the triangle: each with its unknown and those of its rows.
    fn columns(&self) -> impl Iterator<Item = (usize, &[usize], &[f64])> {
        let n = self.active.len();
        let mut rest = self.H.as_slice();
        (0..n).map(move |k| {
            let (own, further) = rest.split_at(n - k);
            rest = further;
            (self.active[k], &self.active[k..], own)
        })
    }

    /// Adds `A'A` times a precision to the lower triangle of a matrix of all unknowns, and `A'z` to a vector.
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

    /// The sum of the products of `A'A` and a symmetric matrix, entry by entry. Of that the lower triangle is read, entries beside the
    /// diagonal doubled.
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

    /// `z'z - 2 s'A'z`: what is left after a step `s`, to first order.
    pub(super) fn sloped(&self, step: &DVector<f64>) -> f64 {
        let along = self.active.iter().zip(&self.g);
        self.q - 2.0 * along.map(|(unknown, g)| step[*unknown] * g).sum::<f64>()
    }

    /// `|z - A s|^2`: what is left after a step.
    pub(super) fn left(&self, step: &DVector<f64>) -> f64 {
        let mut curved = 0.0;
        for (unknown, rows, values) in self.columns() {
            let pairs = rows[1..].iter().zip(&values[1..]);
            let below: f64 = pairs.map(|(row, value)| step[*row] * value).sum();
            curved += step[unknown] * (2.0 * below + step[unknown] * values[0]);
        }
        self.sloped(step) + curved
    }
}

/// Sums in eight parts, which processors add side by side.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a_blocks, b_blocks) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest = a_blocks.remainder().iter().zip(b_blocks.remainder());
    let rest: f64 = rest.map(|(a, b)| a * b).sum();
    for (a, b) in a_blocks.zip(b_blocks) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}
