//! A step of an elimination, and the test whether its pivot is still acceptable.

use super::scalar::Scalar;

/// Ratio of a pivot to its size when the order was chosen, above which the pivot is acceptable whatever stands below it.
const SHRUNK: f64 = 1e-3;
/// Smallest size of a pivot below the ratio [`SHRUNK`], after rows and columns are scaled as when the order was chosen. It applies with
/// [`GROWTH`] and is smaller in proportion where more growth is allowed.
const SMALL: f64 = 1e-8;
/// Largest ratio of an entry below a shrunk pivot to the pivot, for final answers. It bounds the multipliers and thus the growth of
/// round-off.
pub(super) const GROWTH: f64 = 1e3;
/// Largest ratio of an entry below a shrunk pivot to the pivot, for corrections of an iteration whose residuals show the remaining error.
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
    /// A pivot for it; none if it has shrunk too far. `growth` bounds what stands below a small one.
    pub(super) fn pivot<T: Scalar>(
        &self,
        value: T,
        row_scale: f64,
        column_scale: f64,
        growth: f64,
    ) -> Option<Pivot<T>> {
        // Written so that a NaN fails.
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
    /// Largest entry allowed below the pivot, in scaled rows.
    most: f64,
}

impl<T: Scalar> Pivot<T> {
    /// Returns true if the pivot is large enough for an entry below it.
    #[inline]
    pub(super) fn is_acceptable(&self, below: T, row_scale: f64) -> bool {
        self.most == f64::INFINITY || below.reach() * row_scale <= self.most
    }
}
