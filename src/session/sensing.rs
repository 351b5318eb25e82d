//! Sensors at the output steps of static simulations, and the actions of sensors.

use std::fmt::Write as _;

use super::loaded::{CompiledModel, Loaded};
use super::message::exponent;
use admire_solver::model::{Model, Sensor};
use admire_solver::system::{Parameters, Scratch, State, System};

/// Actions required by the sensors that have fired.
#[derive(Clone, PartialEq, Debug, Default)]
pub(super) struct Sensed {
    /// Text about the sensors for the messages.
    pub said: String,
    /// Action HALT: the whole run ends.
    pub halts: bool,
    /// Action RETURN: the current simulation ends.
    pub returns: bool,
    /// Action DT: new time between output steps.
    pub dt: Option<f64>,
    /// Action STEPSIZE: size of the next integration step.
    pub stepsize: Option<f64>,
    /// Action PRINT: an additional output step is written.
    pub prints: bool,
}

impl Loaded {
    /// Evaluates every active sensor at the state that was just written. A sensor that fires stores the value of its EVALUATE function,
    /// which SENVAL returns.
    ///
    /// In statics, RESTART and STEPSIZE have no effect because there is no integrator. PRINT has no effect because every output step is
    /// written anyway.
    pub(crate) fn sense(&mut self) -> Sensed {
        self.compiled();
        let Self {
            model,
            compiled: Some(compiled),
            ..
        } = self
        else {
            return Sensed::default();
        };
        let CompiledModel {
            system,
            parameters,
            state,
            ..
        } = compiled;
        Sensed::at(model, system, parameters, state)
    }
}

impl Sensed {
    /// Adds the actions and the message of a sensor that has just fired in a simulation over time; the message is worded as in ADAMS.
    pub(crate) fn activate(&mut self, sensor: &Sensor, time: f64, value: f64, evaluated: bool) {
        let digits = |value: f64| exponent(value, 6).to_lowercase();
        _ = writeln!(
            self.said,
            "\nSensor/{} has become active at time = {time:.6}.\nCurrent sensed value = {}.",
            sensor.header.id,
            digits(value)
        );
        if sensor.stops {
            let action = if sensor.halts { "HALT" } else { "RETURN" };
            let name = &sensor.header.name;
            _ = writeln!(
                self.said,
                "   Triggered action {action}.\n\n---- START: WARNING ----\nmodel.{name} halting simulation at time {}\n---- END: WARNING ----\n",
                digits(time)
            );
        }
        for (word, value) in [("DT", sensor.dt), ("STEPSIZE", sensor.stepsize)] {
            if let Some(value) = value {
                _ = writeln!(self.said, "   Triggered action {word}={value}.");
            }
        }
        if sensor.prints {
            _ = writeln!(self.said, "   Triggered action PRINT.");
        }
        if evaluated {
            _ = writeln!(self.said, "   Triggered action EVALUATE.");
        }
        for word in &sensor.without_effect {
            _ = writeln!(self.said, "   Action {word} has no effect here.");
        }
        if sensor.stops {
            _ = writeln!(self.said, "  Dynamic Solution stopped.");
        }
        self.halts |= sensor.halts;
        self.returns |= sensor.stops;
        self.prints |= sensor.prints;
        self.dt = sensor.dt.or(self.dt);
        self.stepsize = sensor.stepsize.or(self.stepsize);
    }

    /// Evaluates the sensors of a model at a state. Sensors that fire store their EVALUATE values in the state.
    pub(crate) fn at(
        model: &Model,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
    ) -> Self {
        let mut sensed = Self::default();
        let mut sensors = model.sensors.iter();
        if sensors.all(|sensor| !sensor.header.active) {
            return sensed;
        }
        let mut scratch = Scratch::new(system);
        // A sensor whose function has no value does not fire.
        let _ = system.at(parameters, state, &mut scratch).evaluate();
        for (index, sensor) in model.sensors.iter().enumerate() {
            if !sensor.header.active {
                continue;
            }
            let mut here = system.at(parameters, state, &mut scratch);
            let Ok(value) = here.read_sensor(index) else {
                continue;
            };
            if !sensor.fires(value) {
                continue;
            }
            if let Ok(Some(kept)) = here.read_sensor_evaluate(index) {
                state.sensors[index] = kept;
            }
            let what = match (sensor.halts, sensor.stops) {
                (true, _) => "; it halts the run",
                (false, true) => "; it ends the simulation",
                (false, false) => "",
            };
            _ = writeln!(
                sensed.said,
                "\n  SENSOR/{} '{}' is active at T = {}: its value is {}{what}",
                sensor.header.id,
                sensor.header.name,
                exponent(state.time, 5),
                exponent(value, 5)
            );
            sensed.halts |= sensor.halts;
            sensed.returns |= sensor.stops;
            sensed.dt = sensor.dt.or(sensed.dt);
        }
        sensed
    }
}
