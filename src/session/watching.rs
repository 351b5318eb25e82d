//! Sensors in simulations over time: the time at which a sensor fires is located within the step.

use super::sensing::Sensed;
use admire_solver::model::{Model, SensorCompare};
use admire_solver::motion::{Consistent, Integrator, MotionError, Watched};
use admire_solver::system::{Parameters, Scratch, State, System};

/// All sensors of a model. It records which sensors have fired and are still at or beyond their VALUE; these sensors are called active.
pub(super) struct SensorWatch<'a> {
    model: &'a Model,
    system: &'a System,
    parameters: &'a Parameters,
    scratch: Scratch,
    /// Value of each sensor's function minus VALUE, at the state that was evaluated last.
    seen: Vec<f64>,
    /// Direction in which each sensor may reach its value: 1 if rising, -1 if falling, 0 if it cannot fire.
    armed: Vec<f64>,
    /// One flag for each sensor: true if it has fired and is still at or beyond its value.
    active: Vec<bool>,
    /// True if, at the start, a sensor that ends the simulation is at or beyond its value. If such a sensor is at or beyond its value after the
    /// first step, the simulation ends after that step.
    due: bool,
    /// Projection that makes states inside an integration step satisfy the constraints. The second element is the time increment with which
    /// the projection computes second derivatives by finite differences.
    ///
    /// It is needed if sensors measure accelerations or constraint forces, because the dense output approximates these less accurately than
    /// the end of a step.
    reconciling: Option<(Consistent, f64)>,
}

impl<'a> SensorWatch<'a> {
    pub(crate) fn new(model: &'a Model, system: &'a System, parameters: &'a Parameters) -> Self {
        Self {
            model,
            system,
            parameters,
            scratch: Scratch::new(system),
            seen: vec![f64::NAN; model.sensors.len()],
            armed: vec![0.0; model.sensors.len()],
            active: vec![false; model.sensors.len()],
            due: false,
            reconciling: None,
        }
    }

    /// Determines which sensors are active at the start of a simulation over time. Must be called after [`SensorWatch::fire_at_start`].
    pub(crate) fn go_on_from(&mut self, state: &State) {
        if !self.is_idle() {
            self.active = {
                let values = self.values(state);
                self.firing(&values)
            };
            self.due = self.take_stops();
        }
    }

    /// Marks all active sensors that end a simulation as inactive. Returns true if there were such sensors.
    fn take_stops(&mut self) -> bool {
        let sensors = self.model.sensors.iter().zip(&mut self.active);
        let stops = sensors.filter(|(sensor, active)| sensor.stops && **active);
        stops.map(|(_, active)| *active = false).count() > 0
    }

    /// Returns one flag for each sensor: true if its function is at or beyond VALUE.
    fn firing(&self, values: &[f64]) -> Vec<bool> {
        let sensors = self.model.sensors.iter().zip(values);
        sensors
            .map(|(sensor, value)| !value.is_nan() && sensor.fires(value + sensor.value))
            .collect()
    }

    /// Enables the projection of states inside a step, if a sensor of the model needs it.
    pub(crate) fn reconcile(&mut self, step: f64) {
        let sensors = self.model.sensors.iter().enumerate();
        let mut active = sensors.filter(|(_, sensor)| sensor.header.active);
        if active.any(|(k, _)| self.system.sensor_reads_balance(k)) {
            self.reconciling = Some((Consistent::new(self.system), step));
        }
    }

    /// Returns true if all sensors of the model are switched off.
    pub(crate) fn is_idle(&self) -> bool {
        self.model.sensors.iter().all(|s| !s.header.active)
    }

    /// Returns the function minus VALUE of every sensor; NaN if the sensor is switched off or its function has no value.
    fn values(&mut self, state: &State) -> Vec<f64> {
        let mut all = vec![f64::NAN; self.model.sensors.len()];
        let (system, parameters) = (self.system, self.parameters);
        let mut reconciled = None;
        if let Some((consistent, step)) = &mut self.reconciling {
            let state = reconciled.insert(state.clone());
            if consistent
                .reconcile(system, parameters, state, *step)
                .is_err()
            {
                return all;
            }
        }
        let state = reconciled.as_ref().unwrap_or(state);
        if system
            .evaluate(parameters, state, &mut self.scratch)
            .is_err()
        {
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

    /// Examines the last integration step. If a sensor fires within the step, the integrator is moved back to that time, and the result is
    /// true.
    ///
    /// # Errors
    /// Returns a [`MotionError`] if the shortened step fails.
    pub(crate) fn look(&mut self, integrator: &mut Integrator<'_>) -> Result<bool, MotionError> {
        if self.is_idle() {
            return Ok(false);
        }
        if std::mem::take(&mut self.due) {
            let values = self.values(integrator.state());
            let firing = self.firing(&values);
            let mut sensors = self.model.sensors.iter().zip(firing);
            if sensors.any(|(sensor, fires)| sensor.stops && fires) {
                return Ok(true);
            }
        }
        match integrator.first_passage(self) {
            Some((_, after)) => integrator.end_at_passage(self, after),
            None => Ok(false),
        }
    }

    /// Sets the direction in which each sensor may reach its value: 1 if rising, -1 if falling, 0 if it cannot fire.
    fn arm(&mut self) {
        for (k, sensor) in self.model.sensors.iter().enumerate() {
            let here = self.seen[k];
            self.armed[k] = match sensor.compare {
                _ if self.active[k] || here.is_nan() => 0.0,
                SensorCompare::Eq if here == 0.0 => 0.0,
                SensorCompare::Eq => -here.signum(),
                SensorCompare::Ge if here < 0.0 => 1.0,
                SensorCompare::Le if here > 0.0 => -1.0,
                SensorCompare::Ge | SensorCompare::Le => 0.0,
            };
        }
    }

    /// Fires all sensors that have become active at a state, and returns their actions.
    ///
    /// If `passage` is true, the state is at a located event, and at least one sensor fires. If round-off leaves all sensors short of their
    /// VALUE, the sensor nearest to its VALUE fires.
    pub(crate) fn fire(&mut self, state: &mut State, passage: bool) -> Sensed {
        if self.is_idle() {
            return Sensed::default();
        }
        let values = self.values(state);
        let mut firing = self.firing(&values);
        let new = |k: usize| firing[k] && !self.active[k];
        if passage && !(0..firing.len()).any(new) {
            let armed = (0..firing.len()).filter(|&k| self.armed[k] != 0.0 && !values[k].is_nan());
            let nearest = armed.min_by(|&a, &b| values[a].abs().total_cmp(&values[b].abs()));
            if let Some(nearest) = nearest {
                firing[nearest] = true;
            }
        }
        self.act(state, &values, firing)
    }

    /// Fires all sensors that have reached their value before the simulation starts, and returns their actions. Sensors that end the
    /// simulation fire only after its first step, as in real ADAMS.
    pub(crate) fn fire_at_start(&mut self, state: &mut State) -> Sensed {
        let values = self.values(state);
        let mut firing = self.firing(&values);
        for (sensor, fires) in self.model.sensors.iter().zip(&mut firing) {
            *fires &= !sensor.stops;
        }
        self.act(state, &values, firing)
    }

    /// Fires all sensors in `firing` that were not active before, and returns their actions.
    fn act(&mut self, state: &mut State, values: &[f64], firing: Vec<bool>) -> Sensed {
        let mut sensed = Sensed::default();
        for (k, sensor) in self.model.sensors.iter().enumerate() {
            if !firing[k] || self.active[k] {
                continue;
            }
            let (system, parameters) = (self.system, self.parameters);
            let mut here = system.at(parameters, state, &mut self.scratch);
            let kept = here.read_sensor_evaluate(k).ok().flatten();
            if let Some(kept) = kept {
                state.sensors[k] = kept;
            }
            sensed.activate(sensor, state.time, values[k] + sensor.value, kept.is_some());
        }
        self.active = firing;
        sensed
    }
}

impl Watched for SensorWatch<'_> {
    fn begin(&mut self, state: &State) {
        self.seen = self.values(state);
        self.arm();
    }

    fn excess(&mut self, state: &State) -> f64 {
        self.seen = self.values(state);
        let beyond = self.seen.iter().zip(&self.armed).map(|(value, side)| {
            match value * side {
                _ if *side == 0.0 => f64::NEG_INFINITY,
                // Exactly at its value, a sensor counts as having passed it.
                0.0 => f64::MIN_POSITIVE,
                beyond => beyond,
            }
        });
        // The maximum ignores NaN values.
        beyond.fold(f64::NEG_INFINITY, f64::max)
    }

    fn go_on(&mut self) {
        self.arm();
    }
}
