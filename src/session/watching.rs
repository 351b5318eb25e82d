//! SENSORs during a motion: the time at which they fire is found.

use super::sensing::Sensed;
use admire_solver::model::{Model, SensorCompare};
use admire_solver::motion::{Consistent, Integrator, MotionError, Watched};
use admire_solver::system::{Parameters, Scratch, State, System};

/// The sensors of a model and which of them are active.
pub(super) struct SensorWatch<'a> {
    model: &'a Model,
    system: &'a System,
    parameters: &'a Parameters,
    scratch: Scratch,
    /// Function less VALUE where was looked last.
    seen: Vec<f64>,
    /// The side from which each comes to its value.
    armed: Vec<f64>,
    /// Sensors that have fired and are still beyond.
    active: Vec<bool>,
    /// One that ends the simulation was at its value when it began: it ends after the first step.
    due: bool,
    /// Brings states within a step onto their constraints where accelerations or forces of constraints are watched, which the polynomial
    /// of a step does not have as exactly as its end; and how far apart functions are looked at for that.
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

    /// The same where a motion begins, after [`Watch::fire_at_start`].
    pub(crate) fn go_on_from(&mut self, state: &State) {
        if !self.is_idle() {
            self.active = {
                let values = self.values(state);
                self.firing(&values)
            };
            self.due = self.take_stops();
        }
    }

    /// Sensors that end a simulation, among those that are active: they are not any longer. True if there are any.
    fn take_stops(&mut self) -> bool {
        let sensors = self.model.sensors.iter().zip(&mut self.active);
        let stops = sensors.filter(|(sensor, active)| sensor.stops && **active);
        stops.map(|(_, active)| *active = false).count() > 0
    }

    /// Which sensors are at their value or beyond.
    fn firing(&self, values: &[f64]) -> Vec<bool> {
        let sensors = self.model.sensors.iter().zip(values);
        sensors
            .map(|(sensor, value)| !value.is_nan() && sensor.fires(value + sensor.value))
            .collect()
    }

    /// States within a step are to be brought onto their constraints before they are looked at, if what is watched asks for it.
    pub(crate) fn reconcile(&mut self, step: f64) {
        let sensors = self.model.sensors.iter().enumerate();
        let mut active = sensors.filter(|(_, sensor)| sensor.header.active);
        if active.any(|(k, _)| self.system.sensor_reads_balance(k)) {
            self.reconciling = Some((Consistent::new(self.system), step));
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

    /// Looks at the step that was just done. If a sensor fires inside of it, the integrator is brought to that time: true.
    ///
    /// # Errors
    /// [`MotionError`] where the shorter step is not found.
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
            Some(passage) => integrator.end_at_passage(self, passage),
            None => Ok(false),
        }
    }

    /// On which side of its value each sensor may fire from here on: 1 where it rises to it, -1 where it falls, 0 where it cannot.
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

    /// What the sensors ask for at a state: those that became active fire. If it stands where a passage was found, the nearest to its value
    /// does in any case.
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

    /// What the sensors ask for that are at their value before a motion has begun. Those that end it wait for its first step, as real
    /// ADAMS has them.
    pub(crate) fn fire_at_start(&mut self, state: &mut State) -> Sensed {
        let values = self.values(state);
        let mut firing = self.firing(&values);
        for (sensor, fires) in self.model.sensors.iter().zip(&mut firing) {
            *fires &= !sensor.stops;
        }
        self.act(state, &values, firing)
    }

    /// Lets those fire that were not active.
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
                // A sensor fires at its very value.
                0.0 => f64::MIN_POSITIVE,
                beyond => beyond,
            }
        });
        // What has no value is no number, which the maximum leaves out.
        beyond.fold(f64::NEG_INFINITY, f64::max)
    }

    fn go_on(&mut self) {
        self.arm();
    }
}
