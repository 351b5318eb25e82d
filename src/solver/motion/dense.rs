//! Dense output: states between the ends of a step.

use super::error::MotionError;
use super::integrator::Integrator;
use super::newton::{StageValues, Stages};
use super::tableau::lagrange;
use crate::system::State;

impl Integrator<'_> {
    /// Returns the time at which the last step began; before the first step, the time of the state.
    pub(crate) fn last_time(&self) -> f64 {
        match self.last {
            Some(_) => self.origin.time,
            None => self.state.time,
        }
    }

    /// Returns the state at a time within the last step, from the cubic dense-output polynomial. This state is not reconciled with the
    /// constraints.
    pub(crate) fn between(&self, time: f64) -> State {
        if time == self.state.time {
            return self.state.clone();
        }
        self.continued(time)
    }

    /// Evaluates the dense-output polynomial of the last step at a time within or beyond the step. The discrete states are those at the start
    /// of the step.
    pub(super) fn continued(&self, time: f64) -> State {
        let Some(h) = self.last else {
            return self.state.clone();
        };
        let s = (time - self.origin.time) / h;
        let weights = lagrange(s);
        let mix = |all: &Stages| -> Vec<f64> {
            (0..all[0].len())
                .map(|k| weights[0] * all[0][k] + weights[1] * all[1][k] + weights[2] * all[2][k])
                .collect()
        };
        let (z, w) = (mix(&self.polynomial.z), mix(&self.polynomial.w));
        let step = 1e-4;
        let (up, down) = (lagrange(s + step), lagrange(s - step));
        let slope = |all: &Stages, k: usize| {
            (0..3)
                .map(|i| (up[i] - down[i]) / (2.0 * step * h) * all[i][k])
                .sum()
        };
        let mut state = State::empty();
        self.equations.stage_state(
            self.system,
            &self.origin,
            &StageValues {
                time,
                z: &z,
                w: &w,
                acceleration: &|k| slope(&self.polynomial.w, k),
                state_rate: &|k| slope(&self.polynomial.z, k),
            },
            &mut state,
        );
        state
    }

    /// Returns the state at a time within the last step, reconciled with the constraints at the levels of positions, velocities and
    /// accelerations.
    ///
    /// # Errors
    /// Returns the errors of [`Self::output`].
    pub fn output_at(&mut self, time: f64) -> Result<State, MotionError> {
        let mut state = self.between(time);
        let step = self.settings.hmax * 1e-2;
        self.consistent
            .reconcile(self.system, self.parameters, &mut state, step)
            .map_err(|reason| reason.at(self.origin.time))?;
        state.clear_branches();
        Ok(state)
    }

    /// Undoes the last step: the state returns to the start of that step.
    pub(super) fn undo_step(&mut self) {
        self.state = self.origin.clone();
        self.sizes = self.sizes_before;
        self.statistics.steps -= 1;
        self.statistics.rejected += 1;
    }

    /// Undoes the last step and repeats it up to `time`, which is close to the previous end of the step.
    ///
    /// # Errors
    /// Returns the errors of [`Self::advance_to`].
    pub(super) fn retry_step_to(&mut self, time: f64) -> Result<(), MotionError> {
        self.undo_step();
        self.within = true;
        self.before = None;
        self.factored = None;
        self.h = time - self.state.time;
        self.advance_plainly(time)
    }
}
