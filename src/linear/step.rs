//! A step of an elimination, and whether its pivot still serves.

use super::scalar::Scalar;

/// A pivot may shrink by this against the one it was when the order was chosen, whatever stands below it.
const SHRUNK: f64 = 1e-3;
/// A pivot that has shrunk further will do while it is so large, after rows and columns are scaled as they were then,
const SMALL: f64 = 1e-8;
/// and no entry below it is larger by more than this: the multipliers bound what round-off grows by. For answers, and for steps of an
/// iteration whose residuals say what is left.
const GROWTH: f64 = 1e3;
const GROWTH_OF_STEPS: f64 = 1e7;

/// One step of the elimination. Its pivot, row of U and column of L stand one after the other in the values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub row: u32,
    pub column: u32,
    /// Place of the pivot; U follows, then L.
    pub at: u32,
    pub upper: u32,
    pub lower: u32,
    /// Size of the pivot when it was chosen.
    pub size: f64,
}

impl Step {
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
        let scaled = |at: usize, row: u32| values[at].size() * row_scale[row as usize];
        let pivot = scaled(at, self.row);
        let growth = if for_steps { GROWTH_OF_STEPS } else { GROWTH };
        let lower = at + 1 + self.upper as usize;
        let below = lower..lower + self.lower as usize;
        pivot * column_scale[self.column as usize] >= SMALL * GROWTH / growth
            && below
                .into_iter()
                .all(|k| scaled(k, index[k]) <= growth * pivot)
    }
}
