//! Conditions under which a fit stops before it converges.

use admire_identify::tolerance::Solution;

use crate::settings::{
    LEAD_CLOSE_NATS, LEAD_CLOSE_RISE, LEAD_FAR_NATS, LEAD_LOST_NATS, PACE_STEPS, STILL_NATS,
    STILL_STEPS,
};

/// Criterion of early stopping: log evidence that a fit must approach.
#[derive(Clone, Copy)]
pub(super) struct EarlyStopping {
    /// Log evidence of the leading set in nats, without prior odds. A fit stops if it cannot come near this value.
    pub lead: f64,
}

impl EarlyStopping {
    /// Condition that never stops a fit early.
    pub(super) const NONE: Self = Self {
        lead: f64::NEG_INFINITY,
    };

    /// Returns true if a fit with this log evidence and this predicted gain cannot come near the lead.
    pub(super) fn is_beaten(&self, ln_z: f64, gain: f64) -> bool {
        ln_z + gain < self.lead - LEAD_FAR_NATS
            || ln_z + LEAD_CLOSE_RISE * gain < self.lead - LEAD_CLOSE_NATS
    }

    /// Returns true if a fit will not come near the lead at the pace of its last steps. `course` holds the log evidence after each step, `held`
    /// the number of first steps that are not judged, and `steps` the maximum number of steps.
    pub(super) fn is_out_of_reach(&self, course: &[f64], (held, steps): (usize, usize)) -> bool {
        let count = course.len();
        if count <= held {
            return false;
        }
        let recent = &course[count - 1 - PACE_STEPS..];
        // If new variance components or new derivatives lowered the evidence, the pace is meaningless.
        if recent.windows(2).any(|pair| pair[1] < pair[0]) {
            return false;
        }
        let here = course[count - 1];
        let pace = (here - recent[0]) / PACE_STEPS as f64;
        let left = (steps + 1).saturating_sub(count) as f64;
        here + left * pace < self.lead - LEAD_CLOSE_NATS
    }

    /// Returns true if the predicted log evidence of a fit is far below the lead.
    pub(super) fn is_lost(&self, predicted: &Solution) -> bool {
        predicted.ln_z + predicted.gain < self.lead - LEAD_LOST_NATS
    }
}

/// Returns true if a fit is cycling: none of its last steps raised the log evidence noticeably above its value before these steps. A fit whose
/// last step raised the evidence does not count, because it may still recover from a setback.
pub(super) fn is_still(course: &[f64]) -> bool {
    let Some(from) = course.len().checked_sub(STILL_STEPS + 1) else {
        return false;
    };
    let most = course[from] + STILL_NATS;
    let last = &course[course.len() - 2..];
    last[1] < last[0] + STILL_NATS && course[from + 1..].iter().all(|own| *own < most)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that a fit counts as cycling if its log evidence stagnates. A fit whose log evidence drops in one step and then rises again must
    /// not count as cycling.
    #[test]
    fn a_fit_that_goes_in_a_circle_is_still() {
        let circle = [
            -808.9, -799.1, -799.0, -798.9, -798.9, -798.8, -798.9, -799.4,
        ];
        assert!(is_still(&circle));
        assert!(!is_still(&circle[..5]));
        let set_back = [-830.0, -819.4, -825.0, -823.0, -821.0, -820.0];
        assert!(!is_still(&set_back));
        assert!(!is_still(&[-20.0, -15.0, -11.0]));
    }
}
