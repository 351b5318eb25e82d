//! The two forms in which factors are stored.
//!
//! In statics, one or two solutions follow a factorisation. Repeating recorded operations is fastest there, and the solutions read the values
//! where they are, zeros included.
//!
//! In motion, many solutions follow, often for several right sides at once. They repay the cost of writing rows without zeros. Large systems
//! also do without a long list of operations.

use std::ops::{Div, Mul};

use super::entries::Entries;
use super::factors::Factors;
use super::pattern::{Pattern, Spread};
use super::pivoting::Eliminated;
use super::recorded::Recorded;
use super::scalar::Scalar;
use super::step::Scales;

/// Factors, with the information needed to factor other matrices of the same pattern.
#[derive(Clone, Debug)]
pub(super) enum Form<T> {
    /// Form for few solutions per factorisation.
    Operations(Recorded<T>),
    /// Form for many solutions per factorisation.
    Rows(Pattern, Factors<T>, Spread<T>),
}

impl<T: Scalar> Form<T> {
    /// Creates the form for few solutions, without factors.
    pub(super) fn operations() -> Self {
        Self::Operations(Recorded::default())
    }

    /// Creates the form for many solutions, without factors.
    pub(super) fn rows() -> Self {
        Self::Rows(Pattern::default(), Factors::default(), Spread::default())
    }

    /// Returns true if the form needs the targets of an elimination.
    pub(super) fn takes_targets(&self) -> bool {
        matches!(self, Self::Operations(_))
    }

    /// Takes over the result of an elimination of the matrix.
    pub(super) fn take(&mut self, done: &mut Eliminated<T>, matrix: &Entries<'_, T>) {
        match self {
            Self::Operations(recorded) => *recorded = Recorded::of(done, matrix.values.len()),
            Self::Rows(pattern, factors, _) => (*pattern, *factors) = Pattern::of(done, matrix),
        }
    }

    /// Takes over the pattern of other factors. Returns false if one of the two forms has none.
    pub(super) fn follow<R: Scalar>(&mut self, other: &Form<R>) -> bool {
        match (self, other) {
            (Self::Rows(pattern, ..), Form::Rows(other, ..)) => {
                pattern.clone_from(other);
                true
            }
            _ => false,
        }
    }

    /// Factors another matrix. Returns false if a pivot has shrunk too far, judged by the scales of rows and columns and by the allowed
    /// `growth`.
    pub(super) fn repeat(
        &mut self,
        matrix: &Entries<'_, T>,
        scales: Scales<'_>,
        growth: f64,
    ) -> bool {
        match self {
            Self::Operations(recorded) => recorded.repeat(matrix, scales, growth),
            Self::Rows(pattern, factors, spread) => {
                pattern.fill(matrix, scales, growth, spread, factors)
            }
        }
    }

    /// Solves for the right side `b`, which is overwritten, and writes the solution to `x`. Unknowns without a pivot must be zero in `x` on
    /// entry.
    pub(super) fn solve_into<R>(&self, b: &mut [R], x: &mut [R])
    where
        R: Scalar + Mul<T, Output = R> + Div<T, Output = R>,
    {
        match self {
            Self::Operations(recorded) => recorded.solve_into(b, x),
            Self::Rows(_, factors, _) => factors.solve_into(b, x),
        }
    }

    /// Completes `x`, in which an unknown without a pivot is given, to a null vector of the matrix.
    pub(super) fn follow_free(&self, x: &mut [T]) {
        match self {
            Self::Operations(recorded) => recorded.follow_free(x),
            Self::Rows(_, factors, _) => factors.follow_free(x),
        }
    }

    /// Solves with the transposed matrix and writes the solution to `y`. Rows without a pivot must be zero in `y` on entry.
    pub(super) fn solve_transposed(&self, b: &mut [T], y: &mut [T]) {
        match self {
            Self::Operations(recorded) => recorded.solve_transposed(b, y),
            Self::Rows(_, factors, _) => factors.solve_transposed(b, y),
        }
    }

    /// Returns the number of entries of the factors.
    #[cfg(test)]
    pub(super) fn places(&self) -> usize {
        match self {
            Self::Operations(recorded) => recorded.len(),
            Self::Rows(pattern, ..) => pattern.len(),
        }
    }
}
