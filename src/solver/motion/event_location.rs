//! The times at which something that is watched passes its mark: where in the last step, and a step that ends there.

use super::error::MotionError;
use super::integrator::Integrator;
use super::root::narrowed;
use crate::system::State;

/// Places of a step at which is looked.
pub(super) const PLACES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// A passage is looked for so exactly, as a share of the step.
pub(super) const EXACT: f64 = 1e-13;
/// The step is solved again so often at most.
const SOLUTIONS: usize = 5;
/// The end of a step is looked at so closely first, as a share of it, and so many times less closely then.
const NEAR: f64 = 1e-6;
const WIDER: f64 = 16.0;

/// What is watched along a motion.
pub trait Watched {
    /// A step begins at a state.
    fn begin(&mut self, _state: &State) {}

    /// Above zero if something has passed its mark at a state of the step.
    fn excess(&mut self, state: &State) -> f64;

    /// Nothing had passed where `excess` was asked for last: what comes is judged from there.
    fn go_on(&mut self) {}
}

impl Integrator<'_> {
    /// The first passage in the last step, by its polynomial: a time before and a time after. Both are the start if it lies there.
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
                return Some(narrowed(f, before, (time, excess), exact));
            }
            watched.go_on();
            before = Some((time, excess));
        }
        None
    }

    /// A place next to the start of the last step at which nothing has passed, before `time`, where something has. After an event what is
    /// watched stands at its mark but for round-off: the start itself says nothing.
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

    /// Solves the last step again so that it ends at a passage that was found in it. False if there is none after all: the step ends near it.
    ///
    /// # Errors
    /// [`MotionError`] as of [`Integrator::advance_to`].
    pub fn end_at_passage(
        &mut self,
        watched: &mut impl Watched,
        (_, after): (f64, f64),
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

    /// The passage next to the end of the last step, on either side of it, by its polynomial: the time after it.
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
                return Some(narrowed(f, before, after, EXACT * step).1);
            }
            known = there;
            reach *= WIDER;
        }
        passed.then_some(end)
    }
}
