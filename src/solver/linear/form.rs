//! The two forms in which LU factors are stored: a list of recorded operations, and rows without zeros.
//!
//! In statics, only one or two solutions follow each factorisation. Repeating the recorded operations is fastest there. The solutions read the
//! values in place, including zeros.
//!
//! In motion analysis, many solutions follow each factorisation, often for several right sides at once. They repay the cost of writing rows
//! without zeros. For large systems, this form also avoids a long list of operations.

use std::ops::{Div, Mul};

use super::entries::Entries;
use super::factors::Factors;
use super::pattern::{Pattern, Spread};
use super::pivoting::Eliminated;
use super::recorded::Recorded;
use super::scalar::Scalar;
use super::step::Scales;

/// Factors in one of the two forms, with the information needed to factor other matrices of the same pattern.
#[derive(Clone, Debug)]
pub(super) enum Form<T> {
    /// Recorded operations, for few solutions per factorisation.
    Operations(Recorded<T>),
    /// Rows without zeros, for many solutions per factorisation.
    Rows(Pattern, Factors<T>, Spread<T>),
}

impl<T: Scalar> Form<T> {
    /// Creates the form for few solutions per factorisation, without factors.
    pub(super) fn operations() -> Self {
        Self::Operations(Recorded::default())
    }

    /// Creates the form for many solutions per factorisation, without factors.
    pub(super) fn rows() -> Self {
        Self::Rows(Pattern::default(), Factors::default(), Spread::default())
    }

    /// Returns true if the form needs the list of targets of an elimination ([`Eliminated::targets`]).
    pub(super) fn takes_targets(&self) -> bool {
        matches!(self, Self::Operations(_))
    }

    /// Replaces the stored factors by the result of an elimination of `matrix`.
    pub(super) fn take(&mut self, done: &mut Eliminated<T>, matrix: &Entries<'_, T>) {
        match self {
            Self::Operations(recorded) => *recorded = Recorded::of(done, matrix.values.len()),
            Self::Rows(pattern, factors, _) => (*pattern, *factors) = Pattern::of(done, matrix),
        }
    }

    /// Copies the pattern of other factors. Returns false if either form is [`Self::Operations`], which has no separate pattern.
    pub(super) fn follow<R: Scalar>(&mut self, other: &Form<R>) -> bool {
        match (self, other) {
            (Self::Rows(pattern, ..), Form::Rows(other, ..)) => {
                pattern.clone_from(other);
                true
            }
            _ => false,
        }
    }

    /// Factors another matrix of the same pattern. Returns false if a pivot has become too small, judged by the scales of the rows and columns
    /// and by the allowed `growth`.
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

    /// Solves for the right side `b`, which is overwritten, and writes the solution to `x`. On entry, `x` must be zero for unknowns without a
    /// pivot.
    pub(super) fn solve_into<R>(&self, b: &mut [R], x: &mut [R])
    where
        R: Scalar + Mul<T, Output = R> + Div<T, Output = R>,
    {
        match self {
            Self::Operations(recorded) => recorded.solve_into(b, x),
            Self::Rows(_, factors, _) => factors.solve_into(b, x),
        }
    }

    /// Completes `x` to a null vector of the matrix. On entry, `x` contains the values of the unknowns without a pivot.
    pub(super) fn follow_free(&self, x: &mut [T]) {
        match self {
            Self::Operations(recorded) => recorded.follow_free(x),
            Self::Rows(_, factors, _) => factors.follow_free(x),
        }
    }

    /// Solves the transposed system for the right side `b`, which is overwritten, and writes the solution to `y`. On entry, `y` must be zero
    /// for rows without a pivot.
    pub(super) fn solve_transposed(&self, b: &mut [T], y: &mut [T]) {
        match self {
            Self::Operations(recorded) => recorded.solve_transposed(b, y),
            Self::Rows(_, factors, _) => factors.solve_transposed(b, y),
        }
    }

    /// Returns the number of entries in the factors.
    #[cfg(test)]
    pub(super) fn places(&self) -> usize {
        match self {
            Self::Operations(recorded) => recorded.len(),
            Self::Rows(pattern, ..) => pattern.len(),
        }
    }
}
