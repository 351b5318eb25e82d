//! The two forms in which factors are kept.
//!
//! In statics one or two solutions follow a factorisation. Repeating recorded operations is fastest there, and the solutions read the
//! values where they stand, zeros included.
//!
//! In motion many solutions follow, often of several right sides at once. They repay the cost of writing rows without zeros. Large systems
//! need no long list of operations.

use std::ops::{Div, Mul};

use super::entries::Entries;
use super::factors::Factors;
use super::pattern::{Pattern, Spread};
use super::pivoting::Eliminated;
use super::recorded::Recorded;
use super::scalar::Scalar;

/// Factors with what makes them of other matrices of their pattern.
#[derive(Clone, Debug)]
pub(super) enum Form<T> {
    /// For few solutions.
    Operations(Recorded<T>),
    /// For many.
    Rows(Pattern, Factors<T>, Spread<T>),
}

impl<T: Scalar> Form<T> {
    /// Without factors, for few solutions of each.
    pub(super) fn operations() -> Self {
        Self::Operations(Recorded::default())
    }

    /// Without factors, for many solutions of each.
    pub(super) fn rows() -> Self {
        Self::Rows(Pattern::default(), Factors::default(), Spread::default())
    }

    /// Whether it takes the targets of an elimination.
    pub(super) fn takes_targets(&self) -> bool {
        matches!(self, Self::Operations(_))
    }

    /// Takes over what an elimination of the matrix has found.
    pub(super) fn take(&mut self, done: &mut Eliminated<T>, matrix: &Entries<'_, T>) {
        match self {
            Self::Operations(recorded) => *recorded = Recorded::of(done, matrix.values.len()),
            Self::Rows(pattern, factors, _) => (*pattern, *factors) = Pattern::of(done, matrix),
        }
    }

    /// Takes over the pattern of others; false if one of the two has none.
    pub(super) fn follow<R: Scalar>(&mut self, other: &Form<R>) -> bool {
        match (self, other) {
            (Self::Rows(pattern, ..), Form::Rows(other, ..)) => {
                pattern.clone_from(other);
                true
            }
            _ => false,
        }
    }

    /// Makes the factors anew; false if a pivot has shrunk too far, by the scales of rows and columns and the growth that is allowed.
    pub(super) fn repeat(
        &mut self,
        matrix: &Entries<'_, T>,
        scales: (&[f64], &[f64]),
        growth: f64,
    ) -> bool {
        match self {
            Self::Operations(recorded) => recorded.repeat(matrix, scales, growth),
            Self::Rows(pattern, factors, spread) => {
                pattern.fill(matrix, scales, growth, spread, factors)
            }
        }
    }

    /// Solves for the right side `b`, which is used up; the solution goes to `x`, where unknowns without a pivot are zero.
    pub(super) fn solve_into<R>(&self, b: &mut [R], x: &mut [R])
    where
        R: Scalar + Mul<T, Output = R> + Div<T, Output = R>,
    {
        match self {
            Self::Operations(recorded) => recorded.solve_into(b, x),
            Self::Rows(_, factors, _) => factors.solve_into(b, x),
        }
    }

    /// Changes `x`, where an unknown without a pivot is given, into a motion that nothing resists.
    pub(super) fn follow_free(&self, x: &mut [T]) {
        match self {
            Self::Operations(recorded) => recorded.follow_free(x),
            Self::Rows(_, factors, _) => factors.follow_free(x),
        }
    }

    /// Solves with the transposed matrix; rows without a pivot have zero in `y`.
    pub(super) fn solve_transposed(&self, b: &mut [T], y: &mut [T]) {
        match self {
            Self::Operations(recorded) => recorded.solve_transposed(b, y),
            Self::Rows(_, factors, _) => factors.solve_transposed(b, y),
        }
    }

    /// How many places the factors have.
    #[cfg(test)]
    pub(super) fn places(&self) -> usize {
        match self {
            Self::Operations(recorded) => recorded.len(),
            Self::Rows(pattern, ..) => pattern.len(),
        }
    }
}
