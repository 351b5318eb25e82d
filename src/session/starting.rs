//! Start of a simulation over time: initial conditions, including those of joints, and sensors that already fire.

use super::loaded::{Beginning, CompiledModel, Loaded};
use super::run_state::Session;
use super::sensing::Sensed;
use super::watching::SensorWatch;
use admire_solver::model::{Function, Header, Joint, Model, Motion, MotionAxis, MotionOrder};
use admire_solver::motion;
use admire_solver::motion::{Consistent, Kept, MotionError};
use admire_solver::system::{EquationName, Parameters, Scratch, State, System, name_of};
use admire_syntax::Expression;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Value that the function MODE returns in an initial-conditions analysis (guide/formats.md 3.1).
const MODE_INITIAL: i32 = 3;

impl Session<'_> {
    /// Computes the initial conditions unless they are known, and fires all sensors that have reached their value at the start. The caller
    /// carries out their actions once the simulation has started.
    pub(super) fn begin_sensed(
        &mut self,
        step: f64,
    ) -> Result<(Vec<EquationName>, Sensed), MotionError> {
        let redundant = self.begin(step, false)?;
        let model = &self.model().model;
        if model.sensors.iter().all(|sensor| !sensor.header.active) {
            return Ok((redundant, Sensed::default()));
        }
        let model = model.clone();
        let CompiledModel {
            system,
            parameters,
            state,
            ..
        } = self.model().compiled().value;
        let before = state.sensors.clone();
        let sensed = SensorWatch::new(&model, system, parameters).fire_at_start(state);
        let changed = state.sensors != before;
        if changed {
            // The value of SENVAL has changed and may change accelerations and forces, so the initial conditions are computed again.
            self.model().begin(step, true)?;
        }
        Ok((redundant, sensed))
    }

    /// Computes the initial conditions if they are not known or if `anew` is true, and reports ignored settings. Returns the redundant
    /// constraint equations.
    pub(super) fn begin(
        &mut self,
        step: f64,
        anew: bool,
    ) -> Result<Vec<EquationName>, MotionError> {
        let overridden = self.model().overridden_starts();
        self.report_once(overridden);
        if !self.model().stands() || anew {
            let given = self.model().model.initial_conditions.clone();
            self.messages.without_effect("IC", &given);
        }
        self.model().begin(step, anew)
    }
}

impl Loaded {
    /// Returns true if the current state is an equilibrium that was just written, or satisfies the initial conditions.
    pub(super) fn stands(&mut self) -> bool {
        let known = self.compiled().value.beginning == Beginning::Known;
        known || self.outputs.last.is_some()
    }

    /// Returns warnings about initial conditions of joints that are ignored because a MOTION drives the same degree of freedom.
    fn overridden_starts(&mut self) -> Vec<Diagnostic> {
        match self.compiled().value.beginning {
            Beginning::Dataset => joint_starts(&self.model).1,
            _ => Vec::new(),
        }
    }

    /// Returns a state in which all joints with initial conditions (IC, ICTRAN, ICROT) have their initial displacements and velocities;
    /// `None` if there are no such joints.
    fn joint_start(&self, state: &State, step: f64) -> Result<Option<State>, MotionError> {
        let model = &self.model;
        let (held, _) = joint_starts(model);
        if held.is_empty() {
            return Ok(None);
        }
        let mut found = state.clone();
        // In the first pass, all joints are held at their initial displacements. In the second pass, joints with an initial velocity move
        // at that velocity.
        for rated in [false, true] {
            let mut held_model = model.clone();
            for start in &held {
                if rated && start.rate.is_none() {
                    continue;
                }
                for k in start.drivers(model) {
                    held_model.motions[k].header.active = false;
                }
                held_model.motions.extend(start.as_motion(state.time));
            }
            let system = System::compile(&held_model).value;
            let mut there = system.state();
            there.time = state.time;
            there.mode = MODE_INITIAL;
            there.poses.clone_from(&found.poses);
            let mut memory = Consistent::new(&system);
            let parameters = system.parameters();
            drives_begin_here(&system, &parameters, &mut there);
            motion::assemble(
                &system,
                &parameters,
                &mut there,
                &mut memory,
                Kept::Data,
                step,
            )?;
            found.poses = there.poses;
            if rated {
                found.velocities = there.velocities;
                found.accelerations = there.accelerations;
            }
        }
        Ok(Some(found))
    }

    /// Computes the initial conditions if they are not known or if `anew` is true. Returns the redundant constraint equations.
    ///
    /// This function reports nothing to the user; [`Session::begin`] does that.
    pub(super) fn begin(
        &mut self,
        step: f64,
        anew: bool,
    ) -> Result<Vec<EquationName>, MotionError> {
        let (fresh, start) = {
            let compiled = self.compiled().value;
            let fresh = compiled.beginning == Beginning::Dataset;
            (fresh, compiled.state.clone())
        };
        let held = if fresh {
            self.joint_start(&start, step)?
        } else {
            None
        };
        let CompiledModel {
            system,
            parameters,
            state,
            beginning,
            ..
        } = self.compiled().value;
        if let Some(held) = held {
            state.poses = held.poses;
            state.velocities = held.velocities;
            state.set_moving();
            drives_begin_here(system, parameters, state);
            *beginning = Beginning::Changed;
        }
        let kept = match *beginning {
            Beginning::Known if !anew => return Ok(redundant(system, state)),
            Beginning::Dataset => Kept::Data,
            Beginning::Rest => Kept::Nothing,
            Beginning::Changed | Beginning::Known => Kept::Velocities,
        };
        let mode = std::mem::replace(&mut state.mode, MODE_INITIAL);
        let mut memory = Consistent::new(system);
        if kept == Kept::Nothing {
            // A static solution holds the rate-driven joints still, so their motion starts again at the current time.
            for driven in &mut state.driven {
                if !driven.time.is_nan() {
                    driven.time = state.time;
                }
            }
        }
        let done = motion::assemble(system, parameters, state, &mut memory, kept, step);
        if let Err(error) = done {
            state.mode = mode;
            return Err(error);
        }
        *beginning = Beginning::Known;
        Ok(redundant(system, state))
    }
}

/// Returns the names of the active constraint equations that are redundant.
fn redundant(system: &admire_solver::system::System, state: &State) -> Vec<EquationName> {
    let all = state.redundant.iter().enumerate();
    all.filter(|(k, out)| **out && system.equation_is_active(*k))
        .map(|(k, _)| system.constraint_equation_name(k))
        .collect()
}

/// Lets all rate-driven MOTIONs start again from the current poses.
fn drives_begin_here(system: &System, parameters: &Parameters, state: &mut State) {
    for driven in &mut state.driven {
        driven.time = f64::NAN;
    }
    system.begin_drives(parameters, state, &mut Scratch::new(system));
}

/// Initial condition of a joint: displacement and velocity along or about the axis of the joint.
struct JointStart<'m> {
    joint: &'m Joint,
    axis: MotionAxis,
    value: f64,
    rate: Option<f64>,
}

impl JointStart<'_> {
    /// Returns the indices of the active MOTIONs that drive the same degree of freedom.
    fn drivers(&self, model: &Model) -> Vec<usize> {
        let all = model.motions.iter().enumerate();
        let same = |motion: &Motion| {
            motion.header.active
                && motion.axis == self.axis
                && (motion.i, motion.j) == (self.joint.i, self.joint.j)
        };
        all.filter(|(_, motion)| same(motion))
            .map(|(k, _)| k)
            .collect()
    }

    /// Returns a MOTION that imposes the initial condition at the given time: the displacement, and its rate of change around that time.
    fn as_motion(&self, time: f64) -> Option<Motion> {
        let joint = self.joint;
        let rate = self.rate.unwrap_or(0.0);
        let text = format!("{:e}+({rate:e})*(TIME-({time:e}))", self.value);
        let function = Expression::parse_str(&text).ok()?;
        Some(Motion {
            header: Header {
                name: format!("IC of {}", joint.header.name),
                active: true,
                ..joint.header.clone()
            },
            joint: None,
            i: joint.i,
            j: joint.j,
            axis: self.axis,
            order: MotionOrder::Displacement,
            initial_displacement: None,
            initial_velocity: None,
            function: Function::Expression(function.into()),
        })
    }
}

/// Returns the initial conditions of joints that apply, and warnings about those that do not.
///
/// If a MOTION drives the same degree of freedom, the MOTION takes precedence. If the MOTION prescribes only a velocity or acceleration,
/// the joint still determines the initial displacement.
fn joint_starts(model: &Model) -> (Vec<JointStart<'_>>, Vec<Diagnostic>) {
    let (mut starts, mut complaints) = (Vec::new(), Vec::new());
    for joint in model.joints.iter().filter(|joint| joint.header.active) {
        for (axis, start) in [
            (MotionAxis::Translation(2), joint.initial_translation),
            (MotionAxis::RotationZ, joint.initial_rotation),
        ] {
            let Some((value, rate)) = start else {
                continue;
            };
            let mut start = JointStart {
                joint,
                axis,
                value,
                rate,
            };
            let Some(driver) = start.drivers(model).first().map(|k| &model.motions[*k]) else {
                starts.push(start);
                continue;
            };
            let placed =
                driver.order != MotionOrder::Displacement && driver.initial_displacement.is_none();
            let what = match (placed, rate) {
                (true, None) => None,
                (true, Some(_)) => Some("velocity"),
                (false, None) => Some("displacement"),
                (false, Some(_)) => Some("displacement and velocity"),
            };
            if let Some(what) = what {
                let owner = name_of("JOINT", &joint.header);
                let driver = name_of("MOTION", &driver.header);
                let message =
                    format!("the initial {what} of {owner} is ignored: {driver} drives the joint");
                complaints.push(
                    Diagnostic::warning(Code::ConflictingArguments, message)
                        .about(owner.object())
                        .help(
                            "leave IC, ICTRAN or ICROT of the joint out, or deactivate the MOTION",
                        ),
                );
            }
            if placed {
                start.rate = None;
                starts.push(start);
            }
        }
    }
    (starts, complaints)
}
