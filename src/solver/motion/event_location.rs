//! Event location: finds the time at which a watched function passes through zero within a step, and repeats the step so that it ends there.

use super::error::MotionError;
use super::integrator::Integrator;
use super::root::narrow_bracket;
use crate::system::State;

/// Fractions of a step at which the watched function is sampled.
pub(super) const PLACES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// Width of the bracket around a located event, as a share of the step.
pub(super) const EXACT: f64 = 1e-13;
/// Largest number of times that a step is repeated to end at an event.
const SOLUTIONS: usize = 5;
/// Distance from the end of a step at which the search for a nearby event begins, as a share of the step.
const NEAR: f64 = 1e-6;
/// Factor by which the search distance [`NEAR`] grows from one try to the next.
const WIDER: f64 = 16.0;

/// Event function, whose passage through zero is located along a motion.
pub trait Watched {
    /// Prepares for an interval of the motion that begins at `_state`.
    fn begin(&mut self, _state: &State) {}

    /// Returns a value above zero if an event has passed between the start of the interval and `state`.
    fn excess(&mut self, state: &State) -> f64;

    /// Confirms that no event had passed at the state given to [`excess`](Self::excess) last. Later states are compared with that state.
    fn go_on(&mut self) {}
}

impl Integrator<'_> {
    /// Locates the first event in the last step by the dense-output polynomial. Returns a time before and a time after the event, or `None` if
    /// there is no event. Both times are the start of the step if the event lies there.
    pub fn first_passage(&self, watched: &mut impl Watched) -> Option<(f64, f64)> {
        let (from, to) = (self.last_time(), self.state.time);
        if from == to {
            return None;
        }
        let start = self.continued(from);
        watched.begin(&start);
        let mut before = None;
        for place in PLACES {
            let time = if place < 1.0 {
                from + place * (to - from)
            } else {
                to
            };
            let excess = watched.excess(&self.continued(time));
            if excess > 0.0 {
                let Some(before) = before.or_else(|| self.next_to_start(watched, time)) else {
                    return Some((from, from));
                };
                let exact = EXACT * (to - from);
                let f = |time: f64| watched.excess(&self.continued(time));
                return Some(narrow_bracket(f, before, (time, excess), exact));
            }
            watched.go_on();
            before = Some((time, excess));
        }
        None
    }

    /// Returns a time next to the start of the last step at which no event has passed, and the excess there. `time` is a later time at which an
    /// event has passed. Right after an event, the watched function is zero up to round-off, so its sign at the start of the step carries no
    /// information.
    fn next_to_start(&self, watched: &mut impl Watched, time: f64) -> Option<(f64, f64)> {
        let from = self.last_time();
        let start = watched.excess(&self.continued(from));
        if start <= 0.0 {
            return Some((from, start));
        }
        (1..=6).find_map(|k| {
            let near = from + (time - from) * 0.25_f64.powi(k);
            let excess = watched.excess(&self.continued(near));
            (excess <= 0.0).then_some((near, excess))
        })
    }

    /// Repeats the last step so that it ends at an event found in it, which has passed at the time `after`. Returns false if the repeated
    /// step meets no event after all; it then ends near the expected time.
    ///
    /// # Errors
    /// Returns the errors of [`Integrator::advance_to`].
    pub fn end_at_passage(
        &mut self,
        watched: &mut impl Watched,
        after: f64,
    ) -> Result<bool, MotionError> {
        let mut end = after;
        for _ in 0..SOLUTIONS {
            self.retry_step_to(end)?;
            let Some(found) = self.passage_at_end(watched) else {
                return Ok(false);
            };
            let step = self.state.time - self.last_time();
            let exact = (2.0 * EXACT * step).max(8.0 * f64::EPSILON * end.abs());
            if (found - self.state.time).abs() <= exact {
                break;
            }
            end = found;
        }
        Ok(true)
    }

    /// Locates the event nearest to the end of the last step, before or after this end, by the dense-output polynomial. Returns the time just
    /// after the event, or `None` if there is no event.
    fn passage_at_end(&self, watched: &mut impl Watched) -> Option<f64> {
        let (start, end) = (self.last_time(), self.state.time);
        let step = end - start;
        let mut f = |time: f64| watched.excess(&self.continued(time));
        let at_end = f(end);
        let passed = at_end > 0.0;
        let mut known = (end, at_end);
        let mut reach = NEAR * step;
        while reach <= step {
            let time = if passed { end - reach } else { end + reach };
            let there = (time, f(time));
            if (there.1 > 0.0) != passed {
                let (before, after) = if passed {
                    (there, known)
                } else {
                    (known, there)
                };
                return Some(narrow_bracket(f, before, after, EXACT * step).1);
            }
            known = there;
            reach *= WIDER;
        }
        passed.then_some(end)
    }
}
