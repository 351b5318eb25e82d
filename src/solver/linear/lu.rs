//! Sparse LU factors with an elimination order that is chosen once.
//!
//! The first factorisation eliminates the columns in faer's approximate minimum degree order. In small systems, it searches for sparse columns
//! instead (Markowitz). In each column, it chooses the shortest row whose pivot is large enough for stability, and it records its operations.
//! Later factorisations repeat these operations with other values. If a pivot becomes too small, a new order is chosen. Columns without any
//! acceptable pivot (motions without stiffness) are set aside, and their unknowns are held at zero.
//!
//! faer's complete sparse LU is not used, because it offers neither a refactorisation with frozen pivots nor a report of columns without a
//! pivot. On chains of 100, 1,000 and 10,000 links (670 to 67,140 unknowns), its refactorisation takes 10, 11 and 5 times as long as the
//! refactorisation in this module. Its first factorisation, including the order, is 1.5 to 2.5 times as fast. The times are printed by
//! `cargo test --lib compared_with_faer -- --nocapture`.

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
    /// Number of elimination orders chosen so far.
    pub(crate) orders: usize,
    /// Largest allowed ratio of an entry below a shrunk pivot to that pivot. A shrunk pivot is much smaller than when the order was chosen.
    growth: f64,
    /// Size below which a pivot counts as zero, after the rows and columns are scaled so that their largest entries are about one.
    rank_tolerance: f64,
    /// Whether later factorisations reuse the elimination order. If false, every matrix gets its own order, because a reused order does not
    /// detect pivots that have vanished.
    repeats: bool,
}

impl Lu {
    /// Factors a matrix. All matrices passed to one object must have the same pattern, or contain part of the entries of a common pattern
    /// ([`super::Occupied`]).
    pub(crate) fn factor(&mut self, matrix: &Matrix) {
        self.factor_entries(&matrix.view());
    }
}

impl<T: Scalar> Lu<T> {
    /// Creates factors for final results, when only one or two solutions follow each factorisation.
    pub(crate) fn new(n: usize) -> Self {
        Self::with(n, Form::operations(), GROWTH)
    }

    /// Creates factors for final results, when many solutions follow each factorisation or the system is large.
    pub(crate) fn for_many(n: usize) -> Self {
        Self::with(n, Form::rows(), GROWTH)
    }

    /// Creates factors for many solutions that serve only as corrections in an iteration. Smaller pivots are then acceptable, so an order
    /// remains in use for longer.
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

    /// Sets the size below which a scaled pivot counts as zero. Every matrix then gets its own elimination order.
    pub(crate) fn set_rank_tolerance(&mut self, tolerance: f64) {
        self.rank_tolerance = tolerance;
        self.repeats = false;
    }

    /// Copies the elimination order of other factors, unless these factors already have an order. Both matrices must have the same pattern and
    /// similar magnitudes. Both objects must be made for many solutions ([`Self::for_many`] or [`Self::for_steps`]).
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

    /// Factors a matrix. All matrices passed to one object must have the same pattern, or contain part of the entries of a common pattern
    /// ([`super::Occupied`]).
    pub(crate) fn factor_entries(&mut self, matrix: &Entries<'_, T>) {
        self.factor_in_order(matrix, columns_of);
    }

    /// Factors a matrix. If a new order is needed, the columns are eliminated as `order` lists them. If that list is empty, pivots are searched
    /// for.
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

    /// Eliminates a matrix in a newly chosen order and stores this order.
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

    /// Factors a matrix by repeating the stored operations. Returns false if a pivot has become too small.
    fn repeat(&mut self, matrix: &Entries<'_, T>) -> bool {
        let scales = Scales {
            row: &self.row_scale,
            column: &self.column_scale,
        };
        self.form.repeat(matrix, scales, self.growth)
    }

    /// Replaces the right side `b` by the solution. Unknowns without a pivot are set to zero.
    pub(crate) fn solve(&mut self, b: &mut [T]) {
        let mut x = std::mem::take(&mut self.work);
        self.solve_into(b, &mut x);
        b.copy_from_slice(&x);
        self.work = x;
    }

    /// Solves for many right sides that are stored one after another in `all`, and replaces them by the solutions. The solutions are bitwise
    /// equal to those of separate calls of [`Self::solve`].
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

    /// Solves for a right side whose number type may differ from the matrix's. Writes the solution to `x` and overwrites `b`. Unknowns without
    /// a pivot are set to zero.
    pub(crate) fn solve_into<R>(&self, b: &mut [R], x: &mut [R])
    where
        R: Scalar + Mul<T, Output = R> + Div<T, Output = R>,
    {
        for &column in &self.free {
            x[column as usize] = R::default();
        }
        self.form.solve_into(b, x);
    }

    /// Replaces the right side `b` by the solution of the transposed system. Components of rows without a pivot are set to zero.
    pub(crate) fn solve_transposed(&mut self, b: &mut [T]) {
        let y = &mut self.work;
        for &row in &self.idle {
            y[row as usize] = T::default();
        }
        self.form.solve_transposed(b, y);
        b.copy_from_slice(y);
    }

    /// Returns the number of columns without a pivot, which equals the number of motions without stiffness.
    pub(crate) fn deficiency(&self) -> usize {
        self.free.len()
    }

    /// Returns the rows without a pivot. There are as many of them as columns without a pivot.
    pub(crate) fn rows_without_pivot(&self) -> &[u32] {
        &self.idle
    }

    /// Returns the m-th null vector of the matrix. Its component for the m-th unknown without a pivot is one, and its components for the other
    /// unknowns without a pivot are zero.
    pub(crate) fn null_vector(&self, m: usize) -> Vec<T> {
        let mut x = vec![T::default(); self.n];
        x[self.free[m] as usize] = T::ONE;
        self.form.follow_free(&mut x);
        x
    }

    /// Returns the number of entries in the factors.
    #[cfg(test)]
    pub(crate) fn places(&self) -> usize {
        self.form.places()
    }

    /// Returns the Euclidean norm of a residual whose rows are multiplied by the row scales of the factors.
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

    /// Creates empty factors in both storage forms.
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

    /// Checks that repeated factorisations of a known pattern give correct solutions, also for the transposed matrix. The solutions of both
    /// storage forms are bitwise equal.
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
