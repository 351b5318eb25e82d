//! A step of an elimination, and whether its pivot still serves.

use std::ops::Range;

use super::scalar::Scalar;

/// A pivot may shrink by this against the one it was when the order was chosen, whatever stands below it.
const SHRUNK: f64 = 1e-3;
/// A pivot that has shrunk further will do while it is so large, after rows and columns are scaled as they were then,
const SMALL: f64 = 1e-8;
/// and no entry below it is larger by more than this: the multipliers bound what round-off grows by. For answers, and for steps of an
/// iteration whose residuals say what is left.
const GROWTH: f64 = 1e3;
const GROWTH_OF_STEPS: f64 = 1e7;

/// One step of the elimination. Its pivot and row of U stand one after the other in the values, its column of L with those of the others
/// behind: what goes forwards through a large system reads nothing of U, what goes backwards nothing of L.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub row: u32,
    pub column: u32,
    /// Place of the pivot; U follows.
    pub at: u32,
    pub upper: u32,
    /// Place of L.
    pub below: u32,
    pub lower: u32,
    /// Size of the pivot when it was chosen.
    pub size: f64,
}

impl Step {
    /// Where its row of U stands, without the pivot.
    #[inline]
    pub(super) fn across(&self) -> Range<usize> {
        let from = self.at as usize + 1;
        from..from + self.upper as usize
    }

    /// Where its column of L stands.
    #[inline]
    pub(super) fn down(&self) -> Range<usize> {
        let from = self.below as usize;
        from..from + self.lower as usize
    }

    /// Whether the pivot has not shrunk, or still is large enough against what stands below it.
    pub(super) fn holds<T: Scalar>(
        &self,
        values: &[T],
        index: &[u32],
        (row_scale, column_scale): (&[f64], &[f64]),
        for_steps: bool,
    ) -> bool {
        let at = self.at as usize;
        // Written so that a NaN fails.
        if values[at].size() >= SHRUNK * self.size {
            return true;
        }
        let pivot = values[at].size() * row_scale[self.row as usize];
        let below = |k: usize| values[k].reach() * row_scale[index[k] as usize];
        let growth = if for_steps { GROWTH_OF_STEPS } else { GROWTH };
        pivot * column_scale[self.column as usize] >= SMALL * GROWTH / growth
            && self.down().all(|k| below(k) <= growth * pivot)
    }
}
