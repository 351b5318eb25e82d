//! Sparse LU factors with an elimination order that is found once.
//!
//! The first factorisation takes the columns in faer's approximate minimum degree order, or searches them by sparsity in small systems
//! (Markowitz), chooses the shortest row among those large enough for stability, and writes down what it does. Later ones do the same
//! with other values. A pivot that has shrunk makes it choose anew. Columns without any pivot (motions nothing resists) are put aside and
//! their unknowns held at zero.
//!
//! Why not all of faer's sparse LU: it has neither a repetition with the pivots frozen nor a word about columns without one. On chains of
//! 100, 1,000 and 10,000 links (670 to 67,140 unknowns) a repeated factorisation takes it 10, 11 and 5 times as long; its first one, the
//! order included, is 1.5 to 2.5 times as fast: `cargo test --lib compared_with_faer -- --nocapture`.

use std::ops::{Div, Mul};

use super::entries::Entries;
use super::form::Form;
use super::lanes::Lanes;
use super::matrix::Matrix;
use super::ordering::columns_of;
use super::pivoting::{RANK_TOLERANCE, eliminated};
use super::scalar::Scalar;
use super::step::{GROWTH, GROWTH_OF_STEPS};

/// How many right sides are solved for side by side.
const WIDTH: usize = 8;

/// Sparse LU factors, of real numbers or of complex ones.
#[derive(Clone, Debug)]
pub(crate) struct Lu<T = f64> {
    n: usize,
    form: Form<T>,
    free: Vec<u32>,
    idle: Vec<u32>,
    row_scale: Vec<f64>,
    column_scale: Vec<f64>,
    work: Vec<T>,
    /// [`Entries::fingerprint`] of the matrix that the order is of.
    fingerprint: u64,
    /// How often an order was chosen.
    pub(crate) orders: usize,
    /// What may stand below a small pivot.
    growth: f64,
    /// A pivot below this is none, after rows and columns are scaled to one.
    rank_tolerance: f64,
    /// False if every matrix gets an order of its own, because a repeated order does not look for pivots that have vanished.
    repeats: bool,
}

impl Lu {
    /// Factors a matrix. All matrices given to one object must have the same pattern, or places of it ([`super::Occupied`]).
    pub(crate) fn factor(&mut self, matrix: &Matrix) {
        self.factor_entries(&matrix.view());
    }
}

impl<T: Scalar> Lu<T> {
    /// For answers; one or two solutions follow a factorisation.
    pub(crate) fn new(n: usize) -> Self {
        Self::with(n, Form::operations(), GROWTH)
    }

    /// For answers; many solutions follow a factorisation, or the system is large.
    pub(crate) fn for_many(n: usize) -> Self {
        Self::with(n, Form::rows(), GROWTH)
    }

    /// The same, if its solutions are steps of an iteration alone: an order stays for longer.
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

    /// Sets the scaled size below which a pivot is none. Each matrix then gets an order of its own.
    pub(crate) fn set_rank_tolerance(&mut self, tolerance: f64) {
        self.rank_tolerance = tolerance;
        self.repeats = false;
    }

    /// Takes over the order of other factors, of a matrix of the same pattern and about the same sizes, where it has none of its own. Both
    /// are for many solutions.
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

    /// Factors a matrix. All matrices given to one object must have the same pattern, or places of it ([`super::Occupied`]).
    pub(crate) fn factor_entries(&mut self, matrix: &Entries<'_, T>) {
        self.factor_in_order(matrix, columns_of);
    }

    /// The same, with the columns in this order where one has to be chosen; none if pivots are to be searched for.
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

    /// Chooses the order of the operations.
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

    /// Repeats the known operations; false if a pivot has shrunk too far.
    fn repeat(&mut self, matrix: &Entries<'_, T>) -> bool {
        let scales = (&self.row_scale[..], &self.column_scale[..]);
        self.form.repeat(matrix, scales, self.growth)
    }

    /// Solves for the right side given; unknowns without a pivot are zero.
    pub(crate) fn solve(&mut self, b: &mut [T]) {
        let mut x = std::mem::take(&mut self.work);
        self.solve_into(b, &mut x);
        b.copy_from_slice(&x);
        self.work = x;
    }

    /// The same for many right sides, which follow one another in `all`: what one alone would have, to the bit.
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

    /// The same for a right side of another kind of numbers, with the solution in `x`; what is in `b` is used up.
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

    /// How many motions nothing resists.
    pub(crate) fn deficiency(&self) -> usize {
        self.free.len()
    }

    /// Rows that have no pivot, as many as there are such motions.
    pub(crate) fn left_out(&self) -> &[u32] {
        &self.idle
    }

    /// The m-th motion of the unknowns that nothing resists.
    pub(crate) fn null_vector(&self, m: usize) -> Vec<T> {
        let mut x = vec![T::default(); self.n];
        x[self.free[m] as usize] = T::ONE;
        self.form.follow_free(&mut x);
        x
    }

    /// How many places the factors have.
    #[cfg(test)]
    pub(crate) fn places(&self) -> usize {
        self.form.places()
    }

    /// Length of a residual in the scale of its rows.
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

    /// Without factors, in both forms.
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
                // Elimination is stable by the norm of the solution, not by each of its components.
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
        // The motion (1, 2, 1) is free; the load is balanced otherwise.
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

    /// What the first elimination has found, done with other values, has their solutions: both ways, and to the bit the same in both forms.
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
