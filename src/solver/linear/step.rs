//! An elimination step, and the test whether its pivot is still acceptable for other values.

use super::scalar::Scalar;

/// Limit of the ratio of a pivot to its size when the order was chosen. A pivot above this limit is acceptable regardless of the entries below
/// it. A pivot below this limit is called shrunk.
const SHRUNK: f64 = 1e-3;
/// Smallest acceptable size of a pivot whose ratio is below [`SHRUNK`], multiplied by the row and column scales from when the order was chosen.
/// The limit applies with [`GROWTH`]; where more growth is allowed, the limit is smaller in proportion.
const SMALL: f64 = 1e-8;
/// Largest allowed ratio of an entry below a shrunk pivot ([`SHRUNK`]) to that pivot, for factors of final results. It bounds the multipliers and
/// thus the growth of round-off.
pub(super) const GROWTH: f64 = 1e3;
/// Largest allowed ratio of an entry below a shrunk pivot ([`SHRUNK`]) to that pivot, for corrections in an iteration. It may be large, because
/// the residuals of the iteration show the remaining error.
pub(super) const GROWTH_OF_STEPS: f64 = 1e7;

/// Factors that scale the rows and columns of a matrix to largest entries of about one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales<'a> {
    /// Factor of each row.
    pub row: &'a [f64],
    /// Factor of each column.
    pub column: &'a [f64],
}

/// One step of an elimination.
#[derive(Clone, Copy, Debug)]
pub(super) struct EliminationStep {
    pub row: u32,
    pub column: u32,
    /// Size of the pivot when it was chosen.
    pub size: f64,
}

impl EliminationStep {
    /// Returns the pivot of this step with the given value, or `None` if the value has become too small. For a shrunk pivot, `growth` bounds
    /// the ratio of the entries below it to the pivot.
    pub(super) fn pivot<T: Scalar>(
        &self,
        value: T,
        row_scale: f64,
        column_scale: f64,
        growth: f64,
    ) -> Option<Pivot<T>> {
        // The comparisons are written so that a NaN fails.
        let size = value.size();
        let most = if size >= SHRUNK * self.size {
            f64::INFINITY
        } else if size * row_scale * column_scale >= SMALL * GROWTH / growth {
            growth * size * row_scale
        } else {
            return None;
        };
        Some(Pivot {
            inverse: value.inverse(),
            most,
        })
    }
}

/// The pivot of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pivot<T> {
    pub inverse: T,
    /// Largest entry allowed below the pivot, after multiplication by its row scale.
    most: f64,
}

impl<T: Scalar> Pivot<T> {
    /// Returns true if the pivot is large enough for the entry `below` it, whose row has the scale `row_scale`.
    #[inline]
    pub(super) fn is_acceptable(&self, below: T, row_scale: f64) -> bool {
        self.most == f64::INFINITY || below.reach() * row_scale <= self.most
    }
}
