//! Simulations over time: initial conditions, kinematic simulations and dynamic simulations.

use super::ending::Stop;
use super::loaded::CompiledModel;
use super::measures::Measures;
use super::message::{Progress, Row, equation_as_adams};
use super::run_state::{Flow, Locate, Place, Session};
use super::sensing::Sensed;
use super::simulate::{OutputTimes, Phases, RequestedAnalysis, too_many};
use super::watching::SensorWatch;
use admire_results::StepKind;
use admire_solver::motion;
use admire_solver::motion::{Consistent, Integrator, MotionError, MotionSettings};
use admire_solver::system::{EquationName, State};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Values that the function MODE returns in kinematic and dynamic simulations (guide/formats.md 3.1).
const MODE_KINEMATIC: i32 = 1;
const MODE_DYNAMIC: i32 = 4;

/// Maximum number of integration steps of size HMAX in one simulation. More steps would take hours, and steps below the resolution of time
/// would never end.
const MOST_INNER_STEPS: f64 = 1e9;
/// Number of integration steps between two outputs after which the reason for the short steps is reported.
const MANY_STEPS: usize = 20_000;

impl Session<'_> {
    /// Executes SIMULATE/INITIAL_CONDITIONS: computes the initial conditions and writes the state.
    pub(super) fn initial_conditions(&mut self, phases: Phases, place: Place<'_>) -> Flow {
        if let Some(flow) = self.refuse_motion(place) {
            return flow;
        }
        match self.begin(1e-3, true) {
            Ok(redundant) => {
                self.messages.initial_conditions(phases);
                self.tell_redundant(&redundant);
                if phases == Phases::All {
                    self.write_step(StepKind::InitialConditions)?;
                }
                self.simulation_ended()
            }
            Err(error) => {
                self.messages.initial_conditions(phases);
                self.motion_failed(&error, place);
                self.simulation_failed()
            }
        }
    }

    /// Rejects a simulation over time if the model contains elements that such simulations do not support; `None` if the simulation may
    /// run.
    pub(super) fn refuse_motion(&mut self, place: Place<'_>) -> Option<Flow> {
        let missing = self
            .model()
            .compiled()
            .value
            .system
            .not_in_motion()
            .to_vec();
        if missing.is_empty() {
            return None;
        }
        self.report_once(missing);
        let refusal = Diagnostic::error(
            Code::NotSolvedNatively,
            "this simulation is not executed: its result would omit the elements named above",
        );
        Some(self.refused(refusal, Some(place)))
    }

    /// Executes SIMULATE/KINEMATIC, SIMULATE/DYNAMIC and SIMULATE/TRANSIENT.
    pub(super) fn motion(
        &mut self,
        times: OutputTimes,
        asked: RequestedAnalysis,
        place: Place<'_>,
    ) -> Flow {
        if let Some(flow) = self.refuse_motion(place) {
            return flow;
        }
        self.messages.begin_motion();
        let output = times.at(1) - times.start;
        let (redundant, sensed) = match self.begin_sensed(1e-2 * output) {
            Ok((redundant, sensed)) => (self.new_redundant(&redundant), sensed),
            Err(error) => {
                self.motion_failed(&error, place);
                self.messages.end_simulation();
                return self.simulation_failed();
            }
        };
        let CompiledModel { system, state, .. } = self.model().compiled().value;
        let undetermined = motion::check_determined(system, state);
        // Dynamic states must be integrated even if the parts have no degrees of freedom.
        let fixed = undetermined.is_ok() && state.states.is_empty();
        let kind = match (asked, undetermined) {
            (RequestedAnalysis::Kinematic, Err(error)) => {
                self.motion_failed(&error, place);
                self.messages.end_simulation();
                return self.simulation_failed();
            }
            (RequestedAnalysis::Kinematic, Ok(())) => StepKind::Kinematic,
            (RequestedAnalysis::Transient, _) if fixed => StepKind::Kinematic,
            (_, _) => StepKind::Dynamic,
        };
        if kind == StepKind::Kinematic {
            // The start is an output step of its own, unless it was just written.
            if self.model().outputs.begins_with(times.start, kind) {
                self.write_step(kind)?;
            }
        } else if !self.model().begun {
            self.model().begun = true;
            self.write_step(StepKind::InitialConditions)?;
        }
        let integrator = self.model().model.integrator.clone();
        let kinematics = self.model().model.kinematics.clone();
        let largest = if fixed {
            kinematics.hmax
        } else {
            integrator.hmax
        };
        if let Some(hmax) =
            largest.filter(|hmax| (times.end - times.start) / hmax > MOST_INNER_STEPS)
        {
            let message = format!(
                "HMAX = {hmax:e} needs more than {MOST_INNER_STEPS:e} steps to reach time {}",
                times.end
            );
            let refused =
                self.refused(Diagnostic::error(Code::LimitExceeded, message), Some(place));
            self.messages.end_simulation();
            return refused;
        }
        if kind == StepKind::Kinematic {
            self.messages
                .kinematic_head(&kinematics, redundant.as_ref());
        } else {
            self.messages.dynamic_head(
                &integrator,
                redundant.as_ref(),
                fixed && asked == RequestedAnalysis::Dynamic,
            );
        }
        let done = if fixed {
            self.kinematic_steps(times, kind, (sensed, place))
        } else {
            self.dynamic_steps(times, (sensed, place))
        };
        self.messages.end_simulation();
        let halted = done?;
        match halted {
            None => self.simulation_failed(),
            Some(halted) => {
                self.simulation_ended()?;
                if halted { Err(Stop::Finished) } else { Ok(()) }
            }
        }
    }

    /// Computes the positions at the output times. Returns whether a sensor halts the run, or `None` after a failure.
    fn kinematic_steps(
        &mut self,
        mut times: OutputTimes,
        kind: StepKind,
        (sensed, place): (Sensed, Place<'_>),
    ) -> Result<Option<bool>, Stop> {
        let mut progress = Progress::new(&times);
        let first = Row {
            time: times.start,
            step: times.at(1) - times.start,
            evaluations: 0,
            steps: 0,
        };
        self.messages.progress(&mut progress, first);
        let start = times.start;
        let After::On = self.follow(&sensed, start, (&mut times, &mut 1), place)? else {
            return Ok(None);
        };
        let largest = self.model().model.kinematics.hmax;
        let model = self.model().model.clone();
        let mut compiled = self
            .model()
            .compiled
            .take()
            .expect("a motion has begun with its equations");
        let CompiledModel {
            system,
            parameters,
            state,
            solver,
            ..
        } = &mut compiled;
        state.mode = if kind == StepKind::Kinematic {
            MODE_KINEMATIC
        } else {
            MODE_DYNAMIC
        };
        let mut memory = Consistent::new(system);
        let mut watch = SensorWatch::new(&model, system, parameters);
        watch.go_on_from(state);
        let (mut k, mut steps) = (1, 0);
        let mut ended = Ok(Some(false));
        while k <= times.count {
            let time = times.at(k);
            k += 1;
            let largest = largest.unwrap_or(time - state.time);
            let reached = if watch.is_idle() {
                let taken = motion::advance(system, parameters, state, &mut memory, time, largest);
                taken.map(|taken| (taken, false))
            } else {
                motion::advance_watched(
                    system,
                    parameters,
                    state,
                    &mut memory,
                    time,
                    largest,
                    &mut watch,
                )
            };
            let event = match reached {
                Ok((taken, event)) => {
                    steps += taken;
                    event
                }
                Err(error) => {
                    self.motion_failed(&error, place);
                    ended = Ok(None);
                    break;
                }
            };
            let sensed = watch.fire(state, event);
            let due = !event || motion::has_arrived(state.time, time, largest);
            if !due {
                // After an event, the same output time is approached again.
                k -= 1;
            }
            if due || sensed.prints {
                let time = state.time;
                let row = Row {
                    time,
                    step: largest,
                    evaluations: steps,
                    steps,
                };
                self.messages.progress(&mut progress, row);
                let loaded = self.model();
                let scratch = solver.scratch();
                let mut measures = Measures::new(system, parameters, state, scratch);
                let (model, outputs) = (&loaded.model, &mut loaded.outputs);
                if let Err(diagnostic) = outputs.step(kind, model, &mut measures) {
                    return self.unwritable(&diagnostic).map(|()| None);
                }
                if let Err(stop) = self.tell(times.moment(time, times.at(1) - times.start)) {
                    ended = Err(stop);
                    break;
                }
            }
            match self.follow(&sensed, state.time, (&mut times, &mut k), place) {
                Ok(After::On) => {}
                after => {
                    ended = after.map(After::halted);
                    break;
                }
            }
        }
        self.model().compiled = Some(compiled);
        ended
    }

    /// Integrates the equations of motion up to each output time. Returns whether a sensor halts the run, or `None` after a failure.
    fn dynamic_steps(
        &mut self,
        mut times: OutputTimes,
        (sensed, place): (Sensed, Place<'_>),
    ) -> Result<Option<bool>, Stop> {
        let output = times.at(1) - times.start;
        let settings = MotionSettings::of(&self.model().model.integrator, output);
        let longest = settings.hmax;
        let mut progress = Progress::new(&times);
        let first = Row {
            time: times.start,
            step: settings.hinit,
            evaluations: 0,
            steps: 0,
        };
        self.messages.progress(&mut progress, first);
        let start = times.start;
        let After::On = self.follow(&sensed, start, (&mut times, &mut 1), place)? else {
            return Ok(None);
        };
        let mut compiled = self
            .model()
            .compiled
            .take()
            .expect("a motion has begun with its equations");
        compiled.state.mode = MODE_DYNAMIC;
        let state = compiled.state.clone();
        let interpolate = self.model().model.integrator.interpolate;
        let model = self.model().model.clone();
        let mut watch = SensorWatch::new(&model, &compiled.system, &compiled.parameters);
        watch.reconcile(1e-2 * settings.hmax);
        watch.go_on_from(&state);
        let mut integrator =
            Integrator::new(&compiled.system, &compiled.parameters, state, settings);
        if let Some(h) = sensed.stepsize {
            integrator.set_step(h);
        }
        let mut k = 1;
        let mut ended = Ok(Some(false));
        let mut last: State = integrator.state().clone();
        while k <= times.count {
            let time = times.at(k);
            k += 1;
            let limit = if interpolate { times.end } else { time };
            let begun = (last.time, integrator.statistics().steps + MANY_STEPS);
            let reached = reach(&mut integrator, &mut watch, time, limit, |at| {
                if at.statistics().steps == begun.1 {
                    self.tell_slow(at, begun.0);
                }
            });
            let state = reached.and_then(|event| {
                let state = if event || !interpolate {
                    integrator.output()
                } else {
                    integrator.output_at(time)
                };
                state.map(|state| (state, event))
            });
            let (state, event) = match state {
                Ok(found) => found,
                Err(error) => {
                    self.motion_failed(&error, place);
                    ended = Ok(None);
                    break;
                }
            };
            last = state;
            let sensed = watch.fire(&mut last, event);
            integrator.set_sensors(&last.sensors);
            let due = !event || motion::has_arrived(last.time, time, longest);
            if !due {
                // After an event, the same output time is approached again.
                k -= 1;
            }
            if due || sensed.prints {
                let time = last.time;
                let done = integrator.statistics();
                let row = Row {
                    time,
                    step: integrator.step(),
                    evaluations: done.evaluations,
                    steps: done.steps,
                };
                self.messages.progress(&mut progress, row);
                let loaded = self.model();
                let (system, parameters) = (&compiled.system, &compiled.parameters);
                let scratch = compiled.solver.scratch();
                let mut measures = Measures::new(system, parameters, &last, scratch);
                let (model, outputs) = (&loaded.model, &mut loaded.outputs);
                let written = outputs.step(StepKind::Dynamic, model, &mut measures);
                if let Err(diagnostic) = written {
                    return self.unwritable(&diagnostic).map(|()| None);
                }
                let step = integrator.step();
                if let Err(stop) = self.tell(times.moment(time, step)) {
                    ended = Err(stop);
                    break;
                }
            }
            match self.follow(&sensed, last.time, (&mut times, &mut k), place) {
                Ok(After::On) => {}
                after => {
                    ended = after.map(After::halted);
                    break;
                }
            }
            if event {
                integrator.restart();
            }
            if let Some(h) = sensed.stepsize {
                integrator.set_step(h);
            }
        }
        drop(integrator);
        last.pieces.clear();
        compiled.state = last;
        self.model().compiled = Some(compiled);
        ended
    }

    /// Reports the sensors that fired, and carries out their actions.
    fn follow(
        &mut self,
        sensed: &Sensed,
        time: f64,
        (times, k): (&mut OutputTimes, &mut usize),
        place: Place<'_>,
    ) -> Result<After, Stop> {
        if !sensed.said.is_empty() {
            self.messages.say(&sensed.said);
        }
        self.messages.flush();
        if sensed.halts || sensed.returns {
            return Ok(After::Ended(sensed.halts));
        }
        if let Some(dt) = sensed.dt.filter(|_| time < times.end) {
            let Some(other) = times.every(dt, time) else {
                self.refused(too_many(dt), Some(place))?;
                return Ok(After::Failed);
            };
            (*times, *k) = (other, 1);
        }
        Ok(After::On)
    }

    /// Returns the time and the names of the redundant constraint equations, if these have changed since they were last reported.
    fn new_redundant(&mut self, redundant: &[EquationName]) -> Option<(f64, Vec<String>)> {
        let loaded = self.model();
        let time = loaded.time();
        let told = loaded.said_redundant.replace(redundant.to_vec());
        let new = told.unwrap_or_default() != redundant && !redundant.is_empty();
        new.then(|| (time, redundant.iter().map(equation_as_adams).collect()))
    }

    fn tell_redundant(&mut self, redundant: &[EquationName]) {
        if let Some((time, equations)) = self.new_redundant(redundant) {
            self.messages.say("\n");
            self.messages.redundant(time, &equations);
        }
    }

    /// Tells the user why the integration steps are short; called after many steps without an output.
    fn tell_slow(&mut self, integrator: &Integrator<'_>, since: f64) {
        let (step, why) = (integrator.step(), integrator.governed_by());
        self.messages.say(&format!(
            "\n   ADMIRE: {MANY_STEPS} steps since time {since} without an output; the next step is {step:.1e} long: {why}.\n   If a stiff and light part is the cause, more damping or a larger ERROR allows longer steps.\n\n"
        ));
        self.messages.flush();
    }

    pub(super) fn motion_failed(&mut self, error: &MotionError, place: Place<'_>) {
        let diagnostic = Diagnostic::error(
            Code::NoMotion,
            format!(
                "the simulation ends at time {}: {}",
                error.time, error.reason
            ),
        );
        let diagnostic = Some(place).label(diagnostic);
        self.complain(&diagnostic);
    }
}

/// Integrates up to a time, or up to an earlier event of a sensor; returns true for an event. `done` is called after every integration
/// step.
fn reach(
    integrator: &mut Integrator<'_>,
    watch: &mut SensorWatch<'_>,
    time: f64,
    limit: f64,
    mut done: impl FnMut(&Integrator<'_>),
) -> Result<bool, MotionError> {
    while integrator.state().time < time && integrator.step_towards(limit)? {
        done(integrator);
        if watch.look(integrator)? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// How a simulation continues after the actions of sensors.
enum After {
    On,
    /// A sensor ended the simulation; the flag is true if the whole run must end.
    Ended(bool),
    Failed,
}

impl After {
    /// Returns whether the whole run must end; `None` if no sensor ended the simulation.
    fn halted(self) -> Option<bool> {
        match self {
            Self::Ended(halts) => Some(halts),
            Self::On | Self::Failed => None,
        }
    }
}
