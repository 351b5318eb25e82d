//! Joint friction along a motion: the times at which surfaces begin to stick and to slide.
//!
//! The law of friction is smooth there, but creep begins to count or ceases to: the step ends at that time.

use super::error::MotionError;
use super::integrator::Integrator;
use crate::system::State;

/// Places of a step at which the surface speeds are looked at.
const PLACES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// Halvings of the interval in which a speed passes that of stiction.
const HALVINGS: usize = 50;
/// A passage in this share of the step is one at its start.
const AT_START: f64 = 1e-9;
/// At one time surfaces change so often at most.
const CHANGES: usize = 4;

impl Integrator<'_> {
    /// Looks at the step that was just done: where a surface passes the velocity of stiction inside of it, the step ends there.
    ///
    /// # Errors
    /// [`MotionError`] where the shorter step is not found.
    pub(super) fn settle_grips(&mut self) -> Result<(), MotionError> {
        if !self.system.has_friction() {
            return Ok(());
        }
        for _ in 0..CHANGES {
            let Some((time, passed)) = self.passage() else {
                return Ok(());
            };
            let (from, to) = (self.origin.time, self.state.time);
            if time - from > AT_START * (to - from) {
                self.end_step_at(time)?;
                self.change(&passed);
                return Ok(());
            }
            // Where the last step ended just short of the passage: the same step in the other regime.
            self.state = self.origin.clone();
            self.restart();
            self.change(&passed);
            self.h = (to - from).min(self.h);
            self.advance_plainly(to)?;
        }
        Ok(())
    }

    /// The first time in the last step at which a surface that sticks is too fast, or one that slides slow enough; and which do so.
    fn passage(&mut self) -> Option<(f64, Vec<usize>)> {
        let (from, to) = (self.origin.time, self.state.time);
        let mut earlier = from;
        for place in PLACES {
            let time = from + place * (to - from);
            if self.passed(&self.between(time)).is_empty() {
                earlier = time;
                continue;
            }
            let (mut before, mut after) = (earlier, time);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (before + after);
                if middle <= before || middle >= after {
                    break;
                }
                if self.passed(&self.between(middle)).is_empty() {
                    before = middle;
                } else {
                    after = middle;
                }
            }
            let passed = self.passed(&self.between(after));
            return Some((after, passed));
        }
        None
    }

    /// The frictions whose speed is not that of their regime in the last step.
    fn passed(&mut self, state: &State) -> Vec<usize> {
        let mut slips = std::mem::take(&mut self.slips);
        let scratch = &mut self.equations.scratch;
        self.system
            .slips(self.parameters, state, scratch, &mut slips);
        let grips = self.origin.grips.iter();
        let passed = grips
            .zip(&slips)
            .enumerate()
            .filter(|(_, (grip, slip))| {
                if grip.sticking {
                    **slip > 0.0
                } else {
                    **slip < 0.0
                }
            })
            .map(|(k, _)| k)
            .collect();
        self.slips = slips;
        passed
    }

    /// Surfaces that stuck slide, those that slid stick from here on.
    fn change(&mut self, passed: &[usize]) {
        for &k in passed {
            let sticking = !self.origin.grips[k].sticking;
            let grip = &mut self.state.grips[k];
            grip.sticking = sticking;
            grip.creep = crate::mechanics::Vec3::zeros();
        }
    }
}
