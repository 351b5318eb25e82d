use super::bench_error::BenchError;
use super::config::{AxisMethod, Config};
use super::deck_change::DeckChange;
use super::inputs::{Drive, Inputs};
use super::rig::{FoundWheel, Rigged};
use super::{Side, SteerAxis, Wheel};
use admire_session::backend::{compile, tight_settings};
use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::{MarkerIx, Model, PartIx};
use admire_solver::statics::{Direction, Probe, Probes, SolveError, Solver, StaticSettings};
use admire_solver::system::{ConstraintIx, Parameters, Scratch, Slot, State, System};
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::files::Files;
use admire_syntax::{Address, Dataset};

/// Indices of the items of the compiled system that belong to one wheel: part, markers, load parameters and motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fitted {
    pub side: Side,
    pub part: PartIx,
    pub centre: MarkerIx,
    pub ground: MarkerIx,
    pub loads: [Slot; 4],
    patch: [Slot; 2],
    pub motion: Option<(Slot, ConstraintIx)>,
}

/// Compiled variant of the deck, with its solver.
#[derive(Debug)]
pub(crate) struct Compiled {
    /// Deck with the rig's statements.
    pub rigged: Rigged,
    pub(super) model: Model,
    pub(super) system: System,
    settings: StaticSettings,
    pub(super) solver: Solver,
    pub(super) scratch: Scratch,
    pub(super) wheels: Vec<Fitted>,
    pub(super) steering: Option<Slot>,
    /// Directions of [`Bench::differentiate`](super::Bench::differentiate), as parameters of this variant.
    pub(super) directions: Vec<Direction>,
    /// Markers that are rotated on their parts. Each rotation vector is in radians and in the axes of the marker.
    pub(super) turned: Vec<(MarkerIx, Vec3)>,
    /// Probes given to [`Bench::probe`](super::Bench::probe), compiled for this variant.
    pub(super) probes: Probes,
}

impl Compiled {
    /// Compiles a deck with its rig and with probes; `dataset` is the deck without the rig.
    ///
    /// # Errors
    /// [`BenchError::Deck`] if the deck cannot be solved.
    pub(super) fn new(
        config: &Config,
        dataset: &Dataset,
        files: &Files,
        (found, probes): (&[FoundWheel], &[Probe]),
        rigged: Rigged,
    ) -> Result<Self, BenchError> {
        let lowered = Model::lower_with(&rigged.dataset, files);
        let errors = |all: &[Diagnostic]| -> Vec<Diagnostic> {
            let bad = all.iter().filter(|d| d.severity == Severity::Error);
            bad.cloned().collect()
        };
        let wrong = errors(&lowered.diagnostics);
        if !wrong.is_empty() {
            return Err(BenchError::Deck(wrong));
        }
        let model = lowered.value;
        let refuse = |error: &dyn std::fmt::Display| {
            let message = error.to_string();
            BenchError::Deck(vec![Diagnostic::error(Code::NotSolvedNatively, message)])
        };
        // A FRICTION statement exerts no force in ordinary statics. On the rig, its stick-slip state is carried from one equilibrium to the
        // next.
        let mut rest = model.clone();
        let mut creeping = Vec::new();
        for friction in &mut rest.frictions {
            if std::mem::take(&mut friction.in_statics) {
                creeping.push(friction.header.id);
            }
        }
        let requests = rest.requests.len();
        Probes::extend(&mut rest, probes).map_err(|why| BenchError::Deck(vec![why]))?;
        let mut system = compile(&rest).map_err(|error| refuse(&error))?;
        system.enable_static_friction(&creeping, config.sliding_with);
        let slot = |kind: &str, id: u32| {
            let address = Address {
                kind: kind.to_string(),
                id: Some(id),
                argument: None,
                index: None,
            };
            admire_session::backend::slot(&system, &address).map_err(|error| refuse(&error))
        };
        let mut wheels = Vec::new();
        for (ids, own) in rigged.wheels.iter().zip(found) {
            let marker = |id| {
                model
                    .marker(id)
                    .expect("markers of the rig are in its deck")
            };
            let mut loads = Vec::new();
            for id in ids.loads.into_iter().chain(ids.patch) {
                loads.push(slot("VARIABLE", id)?);
            }
            let motion = match ids.motion {
                Some(id) => {
                    let constraint = system.constraint("MOTION", id);
                    let constraint = constraint.expect("the motion of the rig is in its deck");
                    Some((slot("MOTION", id)?, constraint))
                }
                None => None,
            };
            wheels.push(Fitted {
                side: ids.side,
                part: PartIx(own.part),
                centre: marker(ids.centre),
                ground: marker(ids.ground),
                loads: [loads[0], loads[1], loads[2], loads[3]],
                patch: [loads[4], loads[5]],
                motion,
            });
        }
        let steering = match &config.steering_drive {
            None => None,
            Some(at) => {
                let complain = |why: &dyn std::fmt::Display| {
                    let message = why.to_string();
                    let complaint = config.complain(at, Code::UnknownTarget, message);
                    BenchError::Deck(vec![complaint])
                };
                // The driven statement may be missing: in a variant with free steering, the statement that locks the steering is removed.
                let there = Address::parse(&at.text, &rigged.dataset);
                match there {
                    Ok(address) => Some(
                        admire_session::backend::slot(&system, &address)
                            .map_err(|error| complain(&error))?,
                    ),
                    Err(why) => match Address::parse(&at.text, dataset) {
                        Ok(_) => None,
                        Err(_) => return Err(complain(&why.message)),
                    },
                }
            }
        };
        Ok(Self {
            settings: tight_settings(&system),
            solver: Solver::new(&system),
            scratch: Scratch::new(&system),
            rigged,
            model,
            wheels,
            steering,
            probes: Probes::new(probes, &system, requests),
            system,
            directions: Vec::new(),
            turned: Vec::new(),
        })
    }

    /// Converts each direction to parameters of this variant.
    pub(super) fn direct(&mut self, directions: &[DeckChange]) {
        let of = |change: &DeckChange| change.direction(&self.system);
        self.directions = directions.iter().map(of).collect();
    }

    /// Returns the parameters of the rig that a drive changes, each with its change per unit of the variable.
    pub(super) fn driven(&self, drive: &Drive) -> Vec<(Slot, f64)> {
        let mut slots = Vec::new();
        for wheel in &self.wheels {
            let k = wheel.side.index();
            slots.extend(wheel.loads.iter().copied().zip(drive.loads[k]));
            slots.extend(wheel.motion.map(|(slot, _)| (slot, drive.height[k])));
        }
        slots.extend(self.steering.map(|slot| (slot, drive.steer)));
        slots.retain(|(_, factor)| *factor != 0.0);
        slots
    }

    /// Returns the parameters of the deck with its rotated markers, without inputs of the rig.
    pub(super) fn own_parameters(&self) -> Parameters {
        let mut parameters = self.system.parameters();
        for (marker, turn) in &self.turned {
            parameters.turn(*marker, turn, 1.0);
        }
        parameters
    }

    fn parameters(&self, inputs: &Inputs) -> Parameters {
        let mut parameters = self.own_parameters();
        for wheel in &self.wheels {
            let k = wheel.side.index();
            for (slot, value) in wheel.loads.iter().zip(inputs.loads[k]) {
                parameters.set(*slot, value);
            }
            let at = [inputs.vertical_at_patch, inputs.plane_at_patch];
            for (slot, at) in wheel.patch.iter().zip(at) {
                parameters.set(*slot, f64::from(u8::from(at)));
            }
            if let Some((slot, _)) = wheel.motion {
                parameters.set(slot, inputs.height[k]);
            }
        }
        if let (Some(slot), Some(value)) = (self.steering, inputs.steer) {
            // If the steering input drives a parameter, it is added to the deck's value. If it drives a function, it replaces the function.
            let own = parameters.get(slot);
            parameters.set(slot, if own.is_finite() { own + value } else { value });
        }
        parameters
    }

    /// Finds the equilibrium. Returns the parameter values used and the number of zero-stiffness motions, none of which moves a wheel
    /// carrier. A zero-stiffness motion of a wheel carrier is an error.
    pub(super) fn solve(
        &mut self,
        inputs: &Inputs,
        state: &mut State,
        at: &str,
    ) -> Result<(Parameters, usize), BenchError> {
        let parameters = self.parameters(inputs);
        let no_equilibrium = |why: SolveError| BenchError::NoEquilibrium {
            at: at.to_string(),
            why: Box::new(why),
        };
        let report = self
            .solver
            .solve(&self.system, &parameters, state, &self.settings)
            .map_err(|why| match why {
                SolveError::FreeMotion(motion) => BenchError::Free {
                    at: at.to_string(),
                    motion: motion.to_string(),
                },
                other => no_equilibrium(other),
            })?;
        for motion in &report.free_motions {
            let seen = |name: &admire_solver::system::Name| {
                let carrier = |w: &Fitted| self.system.part_name(w.part) == name;
                self.wheels.iter().any(carrier)
            };
            if seen(&motion.part) || motion.others.iter().any(seen) {
                return Err(BenchError::Free {
                    at: at.to_string(),
                    motion: motion.to_string(),
                });
            }
        }
        Ok((parameters, report.free_motions.len()))
    }

    fn place(&self, state: &State, marker: MarkerIx) -> Pose {
        let frame = &self.model.markers[marker.0];
        state.poses[frame.part.0].compose(&Pose {
            p: frame.qp,
            R: frame.R,
        })
    }

    pub(super) fn wheel(&self, config: &Config, state: &State, wheel: &Fitted) -> Wheel {
        let pose = self.place(state, wheel.centre);
        let design = self.model.parts[wheel.part.0].pose.R;
        let turn = state.poses[wheel.part.0].R * design.transpose();
        Wheel {
            side: wheel.side,
            centre: config.frame.vector(&pose.p),
            spin: config.frame.vector(&pose.R.column(2).into()),
            turn: config.frame.rotation(&turn),
        }
    }

    pub(super) fn geometric_axis(
        &self,
        config: &Config,
        state: &State,
        found: &FoundWheel,
    ) -> Option<SteerAxis> {
        if !matches!(config.axis_method, AxisMethod::Geometric | AxisMethod::Any) {
            return None;
        }
        let [lower, upper] = found.steer_axis?;
        // The deck's markers keep their indices, because the rig's markers come after them.
        let at = |marker| config.frame.vector(&self.place(state, marker).p);
        SteerAxis::through(&at(lower), &at(upper))
    }
}
