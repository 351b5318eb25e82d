//! SENSORs during a motion: the time at which they fire is found.

use super::sensing::Sensed;
use crate::model::{Model, SensorCompare};
use crate::motion::{Integrator, MotionError};
use crate::system::{Parameters, Scratch, State, System};

/// Places of a step at which sensors are looked at.
const PLACES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// Halvings of the interval in which a sensor fires.
const HALVINGS: usize = 60;
/// The step is solved again at most so often for the time at which a sensor fires.
const REPEATS: usize = 4;

/// The sensors of a model and which of them are active.
pub(super) struct Watch<'a> {
    model: &'a Model,
    system: &'a System,
    parameters: &'a Parameters,
    scratch: Scratch,
    /// Function less VALUE at the end of the last step; none before the first.
    before: Option<Vec<f64>>,
    /// Sensors that have fired and are still beyond.
    active: Vec<bool>,
}

impl<'a> Watch<'a> {
    pub(crate) fn new(model: &'a Model, system: &'a System, parameters: &'a Parameters) -> Self {
        Self {
            model,
            system,
            parameters,
            scratch: Scratch::new(system),
            before: None,
            active: vec![false; model.sensors.len()],
        }
    }

    /// True if there is nothing to watch.
    pub(crate) fn is_idle(&self) -> bool {
        self.model.sensors.iter().all(|s| !s.header.active)
    }

    /// Function less VALUE of every sensor; what is off or has no value is NaN.
    fn values(&mut self, state: &State) -> Vec<f64> {
        let mut all = vec![f64::NAN; self.model.sensors.len()];
        let (system, parameters) = (self.system, self.parameters);
        if system.look(parameters, state, &mut self.scratch).is_err() {
            return all;
        }
        for (k, sensor) in self.model.sensors.iter().enumerate() {
            let mut here = system.at(parameters, state, &mut self.scratch);
            if sensor.header.active
                && let Ok(value) = here.read_sensor(k)
            {
                all[k] = value - sensor.value;
            }
        }
        all
    }

    /// Looks at the step that was just done. If a sensor fires inside of it, the integrator is brought to that time: true.
    ///
    /// # Errors
    /// [`MotionError`] where the shorter step is not found.
    pub(crate) fn look(&mut self, integrator: &mut Integrator<'_>) -> Result<bool, MotionError> {
        if self.is_idle() {
            return Ok(false);
        }
        let (from, to) = (integrator.last_time(), integrator.state().time);
        let mut before = match self.before.take() {
            Some(before) => before,
            None => self.values(&integrator.between(from)),
        };
        let mut earlier = from;
        for place in PLACES {
            let time = from + place * (to - from);
            let now = self.values(&integrator.between(time));
            if (0..now.len()).any(|k| self.crosses(k, before[k], now[k])) {
                self.locate(integrator, (earlier, time), &before)?;
                let state = integrator.state().clone();
                self.before = Some(self.values(&state));
                return Ok(true);
            }
            before = now;
            earlier = time;
        }
        self.before = Some(before);
        Ok(false)
    }

    /// True if a sensor comes to its value between two places.
    fn crosses(&self, k: usize, before: f64, now: f64) -> bool {
        if self.active[k] {
            return false;
        }
        match self.model.sensors[k].compare {
            SensorCompare::Eq => before * now < 0.0 || (now == 0.0 && before != 0.0),
            SensorCompare::Ge => before < 0.0 && now >= 0.0,
            SensorCompare::Le => before > 0.0 && now <= 0.0,
        }
    }

    /// Ends the step where the first sensor comes to its value.
    fn locate(
        &mut self,
        integrator: &mut Integrator<'_>,
        (mut from, mut to): (f64, f64),
        before: &[f64],
    ) -> Result<(), MotionError> {
        for _ in 0..REPEATS {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (from + to);
                if middle <= from || middle >= to {
                    break;
                }
                let now = self.values(&integrator.between(middle));
                if (0..now.len()).any(|k| self.crosses(k, before[k], now[k])) {
                    to = middle;
                } else {
                    from = middle;
                }
            }
            let start = integrator.last_time();
            integrator.end_step_at(to)?;
            let state = integrator.state().clone();
            let now = self.values(&state);
            let there = (0..now.len()).any(|k| {
                self.crosses(k, before[k], now[k])
                    || (!self.active[k] && now[k].abs() <= 1e-3 * self.model.sensors[k].error)
            });
            if there {
                return Ok(());
            }
            // The polynomial was a little early: on to the next place of the same step.
            let reach = (to - start).max(f64::EPSILON * to.abs());
            from = state.time;
            to = from + 0.01 * reach;
            integrator.advance_to(to)?;
        }
        Ok(())
    }

    /// What the sensors ask for at a state: those that became active fire.
    pub(crate) fn fire(&mut self, state: &mut State) -> Sensed {
        let mut sensed = Sensed::default();
        if self.is_idle() {
            return sensed;
        }
        let values = self.values(state);
        for (k, sensor) in self.model.sensors.iter().enumerate() {
            let fires = !values[k].is_nan() && sensor.fires(values[k] + sensor.value);
            let was = std::mem::replace(&mut self.active[k], fires);
            if fires && !was {
                let (system, parameters) = (self.system, self.parameters);
                let mut here = system.at(parameters, state, &mut self.scratch);
                let kept = here.read_sensor_evaluate(k).ok().flatten();
                if let Some(kept) = kept {
                    state.sensors[k] = kept;
                }
                sensed.activate(sensor, state.time, values[k] + sensor.value, kept.is_some());
            }
        }
        sensed
    }
}
