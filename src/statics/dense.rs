use crate::system::Sink;

/// A pivot smaller than this, after rows and columns are scaled to one, is none.
const RANK_TOLERANCE: f64 = 1e-11;

/// A dense matrix, by columns, and its LU factors with row pivoting; columns without a pivot are put last and held at zero.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dense {
    n: usize,
    a: Vec<f64>,
    /// Row `rows[k]` of the matrix is row k of the factors.
    rows: Vec<usize>,
    /// Column `columns[k]` of the matrix is column k of the factors.
    columns: Vec<usize>,
    row_scale: Vec<f64>,
    column_scale: Vec<f64>,
    rank: usize,
    work: Vec<f64>,
}

impl Sink for Dense {
    #[inline]
    fn add(&mut self, row: usize, column: usize, value: f64) {
        self.a[column * self.n + row] += value;
    }
}

impl Dense {
    pub fn new(n: usize) -> Self {
        Self {
            n,
            a: vec![0.0; n * n],
            rows: vec![0; n],
            columns: vec![0; n],
            row_scale: vec![1.0; n],
            column_scale: vec![1.0; n],
            rank: 0,
            work: vec![0.0; n],
        }
    }

    pub fn clear(&mut self) {
        self.a.fill(0.0);
    }

    /// Entry of the matrix before it is factored.
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        self.a[column * self.n + row]
    }

    /// Scales and factors in place.
    pub fn factor(&mut self) {
        let n = self.n;
        self.scale();
        for k in 0..n {
            self.rows[k] = k;
            self.columns[k] = k;
        }
        let mut last = n;
        let mut k = 0;
        while k < last {
            let column = &self.a[k * n..(k + 1) * n];
            let (mut pivot, mut size) = (k, column[k].abs());
            for (i, value) in column.iter().enumerate().skip(k + 1) {
                if value.abs() > size {
                    (pivot, size) = (i, value.abs());
                }
            }
            // A NaN is never a pivot; the solution then shows it.
            if size.is_nan() || size < RANK_TOLERANCE {
                last -= 1;
                self.swap_columns(k, last);
                continue;
            }
            if pivot != k {
                self.rows.swap(k, pivot);
                for j in 0..n {
                    self.a.swap(j * n + k, j * n + pivot);
                }
            }
            let inverse = 1.0 / self.a[k * n + k];
            let (left, right) = self.a.split_at_mut((k + 1) * n);
            let multipliers = &mut left[k * n + k + 1..];
            for value in multipliers.iter_mut() {
                *value *= inverse;
            }
            for column in right.chunks_exact_mut(n) {
                let factor = column[k];
                if factor != 0.0 {
                    for (value, multiplier) in column[k + 1..].iter_mut().zip(&*multipliers) {
                        *value -= factor * multiplier;
                    }
                }
            }
            k += 1;
        }
        self.rank = k;
    }

    fn scale(&mut self) {
        let n = self.n;
        self.row_scale.fill(0.0);
        for column in self.a.chunks_exact(n) {
            for (scale, value) in self.row_scale.iter_mut().zip(column) {
                *scale = scale.max(value.abs());
            }
        }
        for scale in &mut self.row_scale {
            *scale = inverse_power_of_two(*scale);
        }
        for (column, scale) in self.a.chunks_exact_mut(n).zip(&mut self.column_scale) {
            let mut largest = 0.0_f64;
            for (value, row) in column.iter_mut().zip(&self.row_scale) {
                *value *= row;
                largest = largest.max(value.abs());
            }
            *scale = inverse_power_of_two(largest);
            for value in column {
                *value *= *scale;
            }
        }
    }

    fn swap_columns(&mut self, a: usize, b: usize) {
        if a == b {
            return;
        }
        let n = self.n;
        self.columns.swap(a, b);
        for i in 0..n {
            self.a.swap(a * n + i, b * n + i);
        }
    }

    /// Solves for the right side given; unknowns without a pivot are zero. Gives the size of what those leave unbalanced, relative to
    /// the scaled right side.
    pub fn solve(&mut self, b: &mut [f64]) -> f64 {
        let n = self.n;
        let y = &mut self.work;
        for k in 0..n {
            y[k] = b[self.rows[k]] * self.row_scale[self.rows[k]];
        }
        for k in 0..self.rank {
            let value = y[k];
            if value != 0.0 {
                let (_, below) = y.split_at_mut(k + 1);
                let column = &self.a[k * n + k + 1..(k + 1) * n];
                for (target, multiplier) in below.iter_mut().zip(column) {
                    *target -= value * multiplier;
                }
            }
        }
        let mut left = 0.0_f64;
        for value in &mut y[self.rank..] {
            left = left.max(value.abs());
            *value = 0.0;
        }
        self.back_substitute();
        for k in 0..n {
            let column = self.columns[k];
            b[column] = self.work[k] * self.column_scale[column];
        }
        left
    }

    /// `U y = y` over the pivots, in `work`.
    fn back_substitute(&mut self) {
        let n = self.n;
        for k in (0..self.rank).rev() {
            let value = self.work[k] / self.a[k * n + k];
            self.work[k] = value;
            if value != 0.0 {
                let column = &self.a[k * n..k * n + k];
                for (target, factor) in self.work[..k].iter_mut().zip(column) {
                    *target -= value * factor;
                }
            }
        }
    }

    /// Solves with the transposed matrix.
    pub fn solve_transposed(&mut self, b: &mut [f64]) {
        let n = self.n;
        let y = &mut self.work;
        for k in 0..n {
            y[k] = b[self.columns[k]] * self.column_scale[self.columns[k]];
        }
        // U' z = y, forwards.
        for k in 0..self.rank {
            let column = &self.a[k * n..k * n + k];
            let sum: f64 = column.iter().zip(&y[..k]).map(|(a, b)| a * b).sum();
            y[k] = (y[k] - sum) / self.a[k * n + k];
        }
        y[self.rank..].fill(0.0);
        // L' w = z, backwards.
        for k in (0..self.rank).rev() {
            let column = &self.a[k * n + k + 1..(k + 1) * n];
            let sum: f64 = column.iter().zip(&y[k + 1..]).map(|(a, b)| a * b).sum();
            y[k] -= sum;
        }
        for k in 0..n {
            let row = self.rows[k];
            b[row] = y[k] * self.row_scale[row];
        }
    }

    /// Length of a residual in the scale of its rows.
    pub fn scaled_norm(&self, g: &[f64]) -> f64 {
        let sum: f64 = g
            .iter()
            .zip(&self.row_scale)
            .map(|(g, s)| (g * s).powi(2))
            .sum();
        sum.sqrt()
    }

    /// How many motions nothing resists.
    pub fn deficiency(&self) -> usize {
        self.n - self.rank
    }

    /// The m-th motion of the unknowns that nothing resists.
    pub fn null_vector(&mut self, m: usize) -> Vec<f64> {
        let n = self.n;
        let free = self.rank + m;
        self.work.fill(0.0);
        for k in 0..self.rank {
            self.work[k] = -self.a[free * n + k];
        }
        self.back_substitute();
        self.work[free] = 1.0;
        let mut out = vec![0.0; n];
        for k in 0..n {
            let column = self.columns[k];
            out[column] = self.work[k] * self.column_scale[column];
        }
        out
    }
}

/// Close to the inverse and free of round-off; one for zero.
fn inverse_power_of_two(x: f64) -> f64 {
    if x > 0.0 && x.is_finite() {
        (-x.log2().round()).exp2()
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: &[&[f64]]) -> Dense {
        let mut m = Dense::new(rows.len());
        for (i, row) in rows.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                m.add(i, j, *value);
            }
        }
        m
    }

    #[test]
    fn solves_both_ways() {
        let rows: &[&[f64]] = &[&[0.0, 2e5, 1.0], &[3.0, 1e5, -1.0], &[1e-3, 4.0, 0.0]];
        let x = [0.3, -1e-5, 7.0];
        let mut m = matrix(rows);
        m.factor();
        let mut b: Vec<f64> = rows
            .iter()
            .map(|r| r.iter().zip(&x).map(|(a, b)| a * b).sum())
            .collect();
        m.solve(&mut b);
        let mut t: Vec<f64> = (0..3)
            .map(|j| (0..3).map(|i| rows[i][j] * x[i]).sum())
            .collect();
        m.solve_transposed(&mut t);
        for k in 0..3 {
            assert!((b[k] - x[k]).abs() < 1e-12 * x[k].abs(), "{b:?}");
            assert!((t[k] - x[k]).abs() < 1e-12 * x[k].abs(), "{t:?}");
        }
    }

    #[test]
    fn a_motion_without_resistance_is_found_and_held() {
        // The motion (1, 2, 1) is free; the load is balanced otherwise.
        let rows: &[&[f64]] = &[&[2.0, -1.0, 0.0], &[-1.0, 1.0, -1.0], &[0.0, -1.0, 2.0]];
        let mut m = matrix(rows);
        m.factor();
        assert_eq!(m.deficiency(), 1);
        let z = m.null_vector(0);
        for row in rows {
            let sum: f64 = row.iter().zip(&z).map(|(a, b)| a * b).sum();
            assert!(sum.abs() < 1e-14, "{z:?}");
        }
        let mut b = [2.0, -2.0, 2.0];
        assert!(m.solve(&mut b) < 1e-14);
        for (k, row) in rows.iter().enumerate() {
            let sum: f64 = row.iter().zip(&b).map(|(a, b)| a * b).sum();
            assert!((sum - [2.0, -2.0, 2.0][k]).abs() < 1e-14, "{b:?}");
        }
    }
}
