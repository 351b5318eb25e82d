//! A step of an elimination, and whether its pivot still serves.

use super::scalar::Scalar;

/// A pivot may shrink by this against the one it was when the order was chosen, whatever stands below it.
const SHRUNK: f64 = 1e-3;
/// A pivot that has shrunk further will do while it is so large, after rows and columns are scaled as they were then,
const SMALL: f64 = 1e-8;
/// and no entry below it is larger by more than this: the multipliers bound what round-off grows by. For answers, and for steps of an
/// iteration whose residuals say what is left.
pub(super) const GROWTH: f64 = 1e3;
pub(super) const GROWTH_OF_STEPS: f64 = 1e7;

/// One step of the elimination.
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
        (row_scale, column_scale): (f64, f64),
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
    /// What may stand below it, in scaled rows.
    most: f64,
}

impl<T: Scalar> Pivot<T> {
    /// Whether it is large enough against an entry below it.
    #[inline]
    pub(super) fn serves(&self, below: T, row_scale: f64) -> bool {
        self.most == f64::INFINITY || below.reach() * row_scale <= self.most
    }
}
