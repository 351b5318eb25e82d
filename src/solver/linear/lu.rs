//! Sparse LU factors with an elimination order that is chosen once.
//!
//! The first factorisation takes the columns in faer's approximate minimum degree order, or searches for sparse columns in small systems
//! (Markowitz). In each column it chooses the shortest row whose pivot is large enough for stability, and it records its operations. Later
//! factorisations repeat them with other values. A pivot that has shrunk too far causes a new choice. Columns without any pivot (motions
//! without stiffness) are set aside, and their unknowns are held at zero.
//!
//! faer's complete sparse LU is not used, because it offers neither a refactorisation with frozen pivots nor a report of columns without a
//! pivot. On chains of 100, 1,000 and 10,000 links (670 to 67,140 unknowns) its refactorisation takes 10, 11 and 5 times as long. Its first
//! factorisation, including the order, is 1.5 to 2.5 times as fast: `cargo test --lib compared_with_faer -- --nocapture`.

use std::ops::{Div, Mul};

use super::entries::Entries;
use super::form::Form;
use super::lanes::Lanes;
use super::matrix::Matrix;
use super::ordering::columns_of;
use super::pivoting::{RANK_TOLERANCE, eliminated};
use super::scalar::Scalar;
use super::step::{GROWTH, GROWTH_OF_STEPS, Scales};

/// Number of right sides that are solved side by side.
const WIDTH: usize = 8;

/// Sparse LU factors of a real or complex matrix.
#[derive(Clone, Debug)]
pub(crate) struct Lu<T = f64> {
    n: usize,
    form: Form<T>,
    free: Vec<u32>,
    idle: Vec<u32>,
    row_scale: Vec<f64>,
    column_scale: Vec<f64>,
    work: Vec<T>,
    /// [`Entries::fingerprint`] of the matrix for which the order was chosen.
    fingerprint: u64,
    /// Number of times that an order was chosen.
    pub(crate) orders: usize,
    /// Largest ratio allowed between an entry below a shrunk pivot and the pivot.
    growth: f64,
    /// Size below which a pivot counts as zero, after rows and columns are scaled to one.
    rank_tolerance: f64,
    /// False if every matrix gets its own order, because a repeated order does not detect pivots that have vanished.
    repeats: bool,
}

impl Lu {
    /// Factors a matrix. All matrices passed to one object must have the same pattern, or entries of a common pattern ([`super::Occupied`]).
    pub(crate) fn factor(&mut self, matrix: &Matrix) {
        self.factor_entries(&matrix.view());
    }
}

impl<T: Scalar> Lu<T> {
    /// Creates factors for final answers, with one or two solutions per factorisation.
    pub(crate) fn new(n: usize) -> Self {
        Self::with(n, Form::operations(), GROWTH)
    }

    /// Creates factors for final answers, with many solutions per factorisation or for large systems.
    pub(crate) fn for_many(n: usize) -> Self {
        Self::with(n, Form::rows(), GROWTH)
    }

    /// Creates factors for many solutions that are only corrections of an iteration. An order then remains in use for longer.
    pub(crate) fn for_steps(n: usize) -> Self {
        Self::with(n, Form::rows(), GROWTH_OF_STEPS)
    }

    fn with(n: usize, form: Form<T>, growth: f64) -> Self {
        Self {
            n,
            form,
            free: Vec::new(),
            idle: Vec::new(),
            row_scale: vec![1.0; n],
            column_scale: vec![1.0; n],
            work: vec![T::default(); n],
            fingerprint: 0,
            orders: 0,
            growth,
            rank_tolerance: RANK_TOLERANCE,
            repeats: true,
        }
    }

    /// Sets the scaled size below which a pivot counts as zero. Each matrix then gets its own order.
    pub(crate) fn set_rank_tolerance(&mut self, tolerance: f64) {
        self.rank_tolerance = tolerance;
        self.repeats = false;
    }

    /// Takes over the order of other factors, unless an order was chosen already. Their matrix must have the same pattern and similar
    /// magnitudes, and both objects must be for many solutions.
    pub(crate) fn follow<R: Scalar>(&mut self, other: &Lu<R>) {
        let may = self.orders == 0 && other.orders > 0 && other.free.is_empty();
        if !(may && self.form.follow(&other.form)) {
            return;
        }
        self.idle.clone_from(&other.idle);
        self.row_scale.clone_from(&other.row_scale);
        self.column_scale.clone_from(&other.column_scale);
        self.fingerprint = other.fingerprint;
        self.orders = 1;
    }

    /// Factors a matrix. All matrices passed to one object must have the same pattern, or entries of a common pattern ([`super::Occupied`]).
    pub(crate) fn factor_entries(&mut self, matrix: &Entries<'_, T>) {
        self.factor_in_order(matrix, columns_of);
    }

    /// Factors a matrix. If an order is chosen, the columns are taken as `order` returns them; if that is empty, pivots are searched for.
    pub(crate) fn factor_in_order(
        &mut self,
        matrix: &Entries<'_, T>,
        order: impl FnOnce(&Entries<'_, T>) -> Vec<u32>,
    ) {
        let known = self.orders > 0 && self.fingerprint == matrix.fingerprint;
        if !(known && self.repeats && self.free.is_empty() && self.repeat(matrix)) {
            self.eliminate(matrix, order);
        }
    }

    /// Eliminates the matrix and chooses a new order.
    fn eliminate(
        &mut self,
        matrix: &Entries<'_, T>,
        order: impl FnOnce(&Entries<'_, T>) -> Vec<u32>,
    ) {
        let mut done = eliminated(
            matrix,
            order(matrix),
            self.form.takes_targets(),
            self.rank_tolerance,
        );
        self.form.take(&mut done, matrix);
        (self.free, self.idle) = (done.free, done.idle);
        (self.row_scale, self.column_scale) = (done.row_scale, done.column_scale);
        self.fingerprint = matrix.fingerprint;
        self.orders += 1;
        self.work.resize(self.n, T::default());
    }

    /// Repeats the known operations. Returns false if a pivot has shrunk too far.
    fn repeat(&mut self, matrix: &Entries<'_, T>) -> bool {
        let scales = Scales {
            row: &self.row_scale,
            column: &self.column_scale,
        };
        self.form.repeat(matrix, scales, self.growth)
    }

    /// Solves in place for a right side; unknowns without a pivot are zero.
    pub(crate) fn solve(&mut self, b: &mut [T]) {
        let mut x = std::mem::take(&mut self.work);
        self.solve_into(b, &mut x);
        b.copy_from_slice(&x);
        self.work = x;
    }

    /// Solves for many right sides that follow one another in `all`. The solutions are bitwise equal to those of separate calls.
    pub(crate) fn solve_many(&self, all: &mut [f64])
    where
        Lanes<WIDTH>: Mul<T, Output = Lanes<WIDTH>> + Div<T, Output = Lanes<WIDTH>>,
    {
        let (mut b, mut x) = (
            vec![Lanes::<WIDTH>::default(); self.n],
            vec![Lanes::<WIDTH>::default(); self.n],
        );
        let width = self.n.max(1);
        for some in all.chunks_mut(WIDTH * width) {
            b.fill(Lanes::default());
            for (lane, right) in some.chunks_exact(width).enumerate() {
                for (to, from) in b.iter_mut().zip(right) {
                    to.0[lane] = *from;
                }
            }
            self.solve_into(&mut b, &mut x);
            for (lane, solution) in some.chunks_exact_mut(width).enumerate() {
                for (to, from) in solution.iter_mut().zip(&x) {
                    *to = from.0[lane];
                }
            }
        }
    }

    /// Solves for a right side of another number type. The solution is written to `x`, and `b` is overwritten.
    pub(crate) fn solve_into<R>(&self, b: &mut [R], x: &mut [R])
    where
        R: Scalar + Mul<T, Output = R> + Div<T, Output = R>,
    {
        for &column in &self.free {
            x[column as usize] = R::default();
        }
        self.form.solve_into(b, x);
    }

    /// Solves with the transposed matrix.
    pub(crate) fn solve_transposed(&mut self, b: &mut [T]) {
        let y = &mut self.work;
        for &row in &self.idle {
            y[row as usize] = T::default();
        }
        self.form.solve_transposed(b, y);
        b.copy_from_slice(y);
    }

    /// Returns the number of columns without a pivot, that is of motions without stiffness.
    pub(crate) fn deficiency(&self) -> usize {
        self.free.len()
    }

    /// Returns the rows without a pivot; they are as many as the columns without one.
    pub(crate) fn rows_without_pivot(&self) -> &[u32] {
        &self.idle
    }

    /// Returns the m-th null vector of the matrix, in which the m-th unknown without a pivot is one.
    pub(crate) fn null_vector(&self, m: usize) -> Vec<T> {
        let mut x = vec![T::default(); self.n];
        x[self.free[m] as usize] = T::ONE;
        self.form.follow_free(&mut x);
        x
    }

    /// Returns the number of entries of the factors.
    #[cfg(test)]
    pub(crate) fn places(&self) -> usize {
        self.form.places()
    }

    /// Returns the norm of a residual with its rows scaled.
    pub(crate) fn scaled_norm(&self, g: &[f64]) -> f64 {
        let sum: f64 = g
            .iter()
            .zip(&self.row_scale)
            .map(|(g, s)| (g * s).powi(2))
            .sum();
        sum.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::Sink;

    fn matrix(rows: &[&[f64]]) -> Matrix {
        let mut m = Matrix::new(rows.len());
        for (i, row) in rows.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                m.add(i, j, *value);
            }
        }
        m.finish();
        m
    }

    /// Returns both forms, without factors.
    fn forms(n: usize) -> [Lu; 2] {
        [Lu::new(n), Lu::for_many(n)]
    }

    #[test]
    fn solves_both_ways_and_again() {
        let rows: &[&[f64]] = &[&[0.0, 2e5, 1.0], &[3.0, 1e5, -1.0], &[1e-3, 4.0, 0.0]];
        let x = [0.3, -1e-5, 7.0];
        let m = matrix(rows);
        for mut lu in forms(3) {
            for _ in 0..2 {
                lu.factor(&m);
                assert_eq!(lu.orders, 1);
                let mut b: Vec<f64> = rows
                    .iter()
                    .map(|r| r.iter().zip(&x).map(|(a, b)| a * b).sum())
                    .collect();
                lu.solve(&mut b);
                let mut t: Vec<f64> = (0..3)
                    .map(|j| (0..3).map(|i| rows[i][j] * x[i]).sum())
                    .collect();
                lu.solve_transposed(&mut t);
                // Elimination is stable relative to the norm of the solution, not to each of its components.
                for k in 0..3 {
                    assert!((b[k] - x[k]).abs() < 1e-12 * 7.0, "{b:?}");
                    assert!((t[k] - x[k]).abs() < 1e-12 * 7.0, "{t:?}");
                }
            }
        }
    }

    #[test]
    fn many_right_sides_are_solved_as_one_is() {
        let rows: &[&[f64]] = &[&[0.0, 2e5, 1.0], &[3.0, 1e5, -1.0], &[1e-3, 4.0, 0.0]];
        for mut lu in forms(3) {
            lu.factor(&matrix(rows));
            let side = |k: usize| vec![k as f64 - 4.0, 0.0, 1.0 / (1.0 + k as f64)];
            let mut many: Vec<f64> = (0..19).flat_map(side).collect();
            lu.solve_many(&mut many);
            for (k, found) in many.chunks_exact(3).enumerate() {
                let mut one = side(k);
                lu.solve(&mut one);
                assert_eq!(found, one);
            }
        }
    }

    #[test]
    fn a_motion_without_resistance_is_found_and_held() {
        // (1, 2, 1) is a null vector, and the load does no work along it.
        let rows: &[&[f64]] = &[&[2.0, -1.0, 0.0], &[-1.0, 1.0, -1.0], &[0.0, -1.0, 2.0]];
        for mut lu in forms(3) {
            lu.factor(&matrix(rows));
            assert_eq!(lu.deficiency(), 1);
            let z = lu.null_vector(0);
            for row in rows {
                let sum: f64 = row.iter().zip(&z).map(|(a, b)| a * b).sum();
                assert!(sum.abs() < 1e-14, "{z:?}");
            }
            let mut b = [2.0, -2.0, 2.0];
            lu.solve(&mut b);
            for (k, row) in rows.iter().enumerate() {
                let sum: f64 = row.iter().zip(&b).map(|(a, b)| a * b).sum();
                assert!((sum - [2.0, -2.0, 2.0][k]).abs() < 1e-14, "{b:?}");
            }
        }
    }

    #[test]
    fn a_pivot_that_vanishes_makes_it_choose_anew() {
        for mut lu in forms(2) {
            lu.factor(&matrix(&[&[1.0, 1.0], &[1.0, 2.0]]));
            lu.factor(&matrix(&[&[0.0, 1.0], &[1.0, 0.0]]));
            assert_eq!(lu.orders, 2);
            let mut b = [3.0, 5.0];
            lu.solve(&mut b);
            assert_eq!(b, [5.0, 3.0]);
        }
    }

    /// Factors of a known pattern with other values give correct solutions, also transposed; both forms give bitwise equal solutions.
    #[test]
    fn a_known_pattern_takes_other_values() {
        let n = 60;
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1);
            (seed >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
        };
        let places: Vec<(usize, usize)> = (0..n)
            .flat_map(|row| (0..n).map(move |column| (row, column)))
            .filter(|(row, column)| row == column || random() > 0.42)
            .collect();
        let mut forms = forms(n);
        for _ in 0..3 {
            let mut m = Matrix::new(n);
            for &(row, column) in &places {
                let own = if row == column { 2.0 } else { 0.0 };
                m.add(row, column, random() + own);
            }
            m.finish();
            let b: Vec<f64> = (0..n).map(|_| random()).collect();
            let found = forms.each_mut().map(|lu| {
                lu.factor(&m);
                let (mut x, mut y) = (b.clone(), b.clone());
                lu.solve(&mut x);
                lu.solve_transposed(&mut y);
                let (mut left, mut left_transposed) = (b.clone(), b.clone());
                for (row, column, value) in m.entries() {
                    left[row] -= value * x[column];
                    left_transposed[column] -= value * y[row];
                }
                for left in left.iter().chain(&left_transposed) {
                    assert!(left.abs() < 1e-12, "{left:e}");
                }
                x
            });
            assert_eq!(found[0], found[1]);
        }
        assert_eq!(forms.map(|lu| lu.orders), [1, 1]);
    }
}
