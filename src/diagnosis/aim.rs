//! What a fit is measured by.

use nalgebra::DVector;

use admire_identify::tolerance::Solution;

/// What the linear model promises has to come to within so many nats of the model that leads,
const BEHIND: f64 = 50.0;
/// or to so many, once what is left of the way is small: it may rise by so many times that.
const CLOSE: (f64, f64) = (7.0, 3.0);
/// or, at the pace of so many steps, to within the first of these;
const PACE: usize = 3;
/// or, sizes of its own granted, to within so many nats after the first step. What is promised of a far way may be half of what it brings.
const LOST: f64 = 200.0;
/// A fit whose evidence rises by less than so many nats in so many steps goes in a circle: each step leads down at the sizes of tolerances
/// where it begins, and those found at its end lead back.
const STILL: (usize, f64) = (4, 0.2);
/// A fit is on the way to a known end that its linear model puts within so many nats of its own.
const SAME: f64 = 0.5;

/// What a fit is measured by: where it need not go on.
#[derive(Clone, Copy)]
pub(super) struct Aim<'a> {
    /// Evidence in nats, prior left out, that it has to come near to.
    pub lead: f64,
    /// Where another fit of the same unknowns ended. One that leads there ends.
    pub known: Option<&'a [f64]>,
    /// Evidence in nats, prior left out: a fit that begins below goes no further.
    pub least: f64,
}

impl Aim<'_> {
    /// Every fit goes on to its end.
    pub(super) const NONE: Self = Self {
        lead: f64::NEG_INFINITY,
        known: None,
        least: f64::NEG_INFINITY,
    };

    /// True where a fit that begins with so much evidence begins astray.
    pub(super) fn is_astray(&self, begun: f64) -> bool {
        begun < self.least
    }

    /// True where a fit that has so much evidence, and so many nats to gain, will not come near.
    pub(super) fn is_beaten(&self, ln_z: f64, gain: f64) -> bool {
        ln_z + gain < self.lead - BEHIND || ln_z + CLOSE.1 * gain < self.lead - CLOSE.0
    }

    /// True where a fit that gains as much as in its last steps will not come near in those it has left.
    pub(super) fn is_out_of_reach(&self, course: &[f64], (held, steps): (usize, usize)) -> bool {
        let count = course.len();
        if count <= held {
            return false;
        }
        let recent = &course[count - 1 - PACE..];
        // Where new sizes or derivatives set it back, its pace says nothing.
        if recent.windows(2).any(|pair| pair[1] < pair[0]) {
            return false;
        }
        let here = course[count - 1];
        let pace = (here - recent[0]) / PACE as f64;
        let left = (steps + 1).saturating_sub(count) as f64;
        here + left * pace < self.lead - CLOSE.0
    }

    /// True where a fit is far behind even if its way brings twice what it promises.
    pub(super) fn is_lost(&self, promised: &Solution) -> bool {
        promised.ln_z + promised.gain < self.lead - LOST
    }

    /// True for a fit at `x` whose linear model leads to the known end.
    pub(super) fn is_known(&self, x: &[f64], reached: &Solution) -> bool {
        let known = self.known.filter(|known| known.len() == x.len());
        known.is_some_and(|known| {
            let there =
                DVector::from_iterator(known.len(), known.iter().zip(x).map(|(k, x)| k - x));
            reached.nats_below_maximum(&there) < SAME
        })
    }
}

/// True where a fit goes in a circle: none of its last steps reached more evidence than there was before them. A fit whose last step
/// raised the evidence may still come back from a setback.
pub(super) fn is_still(course: &[f64]) -> bool {
    let Some(from) = course.len().checked_sub(STILL.0 + 1) else {
        return false;
    };
    let most = course[from] + STILL.1;
    let last = &course[course.len() - 2..];
    last[1] < last[0] + STILL.1 && course[from + 1..].iter().all(|own| *own < most)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fit that goes up and down between two ends is still. One that exact derivatives set back, and that rises again, is not.
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
