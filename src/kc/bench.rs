//! A deck on the rig, solved: states of the axle, its compliance and its tangents.

use std::collections::BTreeMap;

use super::axle::{AxleState, WheelState};
use super::config::{AxisMethod, Config};
use super::derivatives::Derivatives;
use super::inputs::{Drive, Inputs};
use super::rig::{FoundWheel, Rigged, Variant, rigged};
use super::{Side, SteerAxis, Wheel, contact};
use crate::backend::{compile, tight_settings};
use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::mechanics::{Pose, Vec3, Vec6};
use crate::model::{MarkerIx, Model, PartIx};
use crate::statics::{Balance, Settings, SolveError, Solver};
use crate::syntax::files::Files;
use crate::syntax::{Address, Dataset};
use crate::system::{ConstraintIx, Grasp, Parameters, Scratch, Slot, State, System};

/// The motion of a wheel per unit of what is driven.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct WheelRate {
    /// Translation of the centre and rotation.
    pub motion: Vec6,
    /// Vertical load.
    pub load: f64,
}

/// A state of the axle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Observation {
    /// Wheels and compliance.
    pub axle: AxleState,
    /// Vertical load of each wheel.
    pub load: [f64; 2],
    /// How the wheels move per unit of what is driven.
    pub rates: [Option<WheelRate>; 2],
    /// What the joints with friction do; `None` without any.
    pub friction: Option<Grasp>,
}

/// Why the rig has no answer.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BenchError {
    /// The deck cannot be used.
    #[error("the deck cannot be put on the rig")]
    Deck(Vec<Diagnostic>),
    /// No equilibrium.
    #[error("{at}: {why}")]
    NoEquilibrium {
        /// Which test and point.
        at: String,
        /// Why.
        why: Box<SolveError>,
    },
    /// No height of the axle bears its load.
    #[error("{at}: no height of both wheels keeps the load of the axle")]
    NoAxleLoad {
        /// Which test and point.
        at: String,
    },
    /// A motion of the wheel that nothing resists.
    #[error("{at}: the compliance is not defined: {motion}")]
    Free {
        /// Which test.
        at: String,
        /// The motion, in words.
        motion: String,
    },
}

/// Where a wheel is in the compiled system.
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

/// One variant, compiled.
#[derive(Debug)]
pub(crate) struct Compiled {
    /// The deck with the rig.
    pub rigged: Rigged,
    pub(super) model: Model,
    pub(super) system: System,
    settings: Settings,
    pub(super) solver: Solver,
    pub(super) scratch: Scratch,
    pub(super) wheels: Vec<Fitted>,
    pub(super) steering: Option<Slot>,
}

/// A deck on the rig.
#[derive(Debug)]
pub struct Bench<'a> {
    /// What the file says.
    pub config: &'a Config,
    dataset: &'a Dataset,
    files: &'a Files,
    model: &'a Model,
    /// The wheels that are in the deck.
    pub wheels: Vec<FoundWheel>,
    variants: BTreeMap<Variant, Compiled>,
}

/// The states a sweep goes on from: of the deck, and of its mirror image.
#[derive(Clone, Debug)]
pub struct Chain {
    states: [State; 2],
    /// Joints with friction rub; before, they are as after a shake.
    rubs: bool,
}

impl<'a> Bench<'a> {
    /// Finds the wheels.
    ///
    /// # Errors
    /// What the file names wrongly.
    pub fn new(
        config: &'a Config,
        (dataset, files, model): (&'a Dataset, &'a Files, &'a Model),
    ) -> Result<Self, Vec<Diagnostic>> {
        Ok(Self {
            config,
            dataset,
            files,
            model,
            wheels: super::rig::wheels(config, dataset, model)?,
            variants: BTreeMap::new(),
        })
    }

    /// What was left of the forces on a part at worst, in all equilibria so far.
    pub(crate) fn balance(&self) -> Balance {
        let mut worst = Balance::default();
        for compiled in self.variants.values() {
            if let Some(found) = compiled.solver.worst_balance() {
                worst.or_worse(found);
            }
        }
        worst
    }

    /// The deck as it came.
    pub(crate) fn dataset(&self) -> &'a Dataset {
        self.dataset
    }

    /// A variant, compiled if it was not before.
    ///
    /// # Errors
    /// [`BenchError::Deck`] if the deck cannot be solved.
    pub(crate) fn variant(&mut self, variant: Variant) -> Result<&mut Compiled, BenchError> {
        if !self.variants.contains_key(&variant) {
            let deck = (self.dataset, self.model);
            let rigged = rigged(self.config, deck, &self.wheels, variant)
                .map_err(|why| BenchError::Deck(vec![why]))?;
            let compiled = Compiled::new(self, rigged)?;
            self.variants.insert(variant, compiled);
        }
        Ok(self
            .variants
            .get_mut(&variant)
            .expect("compiled just above"))
    }

    /// A chain that begins at the design position.
    ///
    /// # Errors
    /// As [`Bench::variant`].
    pub fn chain(&mut self, variant: Variant) -> Result<Chain, BenchError> {
        let state = self.variant(variant)?.system.state();
        Ok(Chain {
            states: [state.clone(), state],
            rubs: false,
        })
    }

    /// From here on joints with friction rub: they hold what comes now, and nothing yet.
    ///
    /// # Errors
    /// As [`Bench::variant`].
    pub(crate) fn let_rub(
        &mut self,
        variant: Variant,
        chain: &mut Chain,
    ) -> Result<(), BenchError> {
        let compiled = self.variant(variant)?;
        let parameters = compiled.system.parameters();
        for state in &mut chain.states {
            let scratch = &mut compiled.scratch;
            compiled.system.creep_on(&parameters, state, scratch);
        }
        chain.rubs = true;
        Ok(())
    }

    /// Solves for these inputs from where the chain is, and looks at nothing.
    ///
    /// # Errors
    /// As [`Bench::observe`].
    pub(crate) fn settle(
        &mut self,
        variant: Variant,
        chain: &mut Chain,
        inputs: &Inputs,
        at: &str,
    ) -> Result<(), BenchError> {
        let mirror = self.config.mirror;
        let compiled = self.variant(variant)?;
        let rubs = chain.rubs;
        let [own, other] = &mut chain.states;
        let mut settle = |inputs: &Inputs, state: &mut State| -> Result<(), BenchError> {
            let (parameters, _) = compiled.solve(inputs, state, at)?;
            if rubs {
                let scratch = &mut compiled.scratch;
                compiled.system.creep_on(&parameters, state, scratch);
            }
            Ok(())
        };
        settle(inputs, own)?;
        if mirror {
            settle(&inputs.mirrored(), other)?;
        }
        Ok(())
    }

    /// Solves for these inputs from where the chain is, and looks at the wheels. `drive` asks for tangents.
    ///
    /// # Errors
    /// No equilibrium, or a free motion of a wheel; `at` says where.
    pub fn observe(
        &mut self,
        variant: Variant,
        chain: &mut Chain,
        (inputs, drive): (&Inputs, Option<&Drive>),
        at: &str,
    ) -> Result<Observation, BenchError> {
        let (config, wheels, rubs) = (self.config, self.wheels.clone(), chain.rubs);
        let job =
            |compiled: &mut Compiled, inputs: &Inputs, drive: Option<&Drive>, state: &mut State| {
                compiled.observe((config, &wheels), (inputs, drive), (state, rubs), at)
            };
        let compiled = self.variant(variant)?;
        let [own, mirrored] = &mut chain.states;
        let mut seen = job(compiled, inputs, drive, own)?;
        if !config.mirror {
            return Ok(seen);
        }
        let side = wheels[0].side;
        let other_inputs = inputs.mirrored();
        let other_drive = drive.map(Drive::mirrored);
        // The other wheel of a symmetric load case needs no solve of its own.
        let k = side.index();
        let alike = own.grips == mirrored.grips
            && other_inputs.height[k] == inputs.height[k]
            && other_inputs.loads[k] == inputs.loads[k]
            && other_inputs.steer.unwrap_or(0.0) == inputs.steer.unwrap_or(0.0)
            && other_drive.map(|d| (d.height[k], d.loads[k], d.steer))
                == drive.map(|d| (d.height[k], d.loads[k], d.steer));
        let other = if alike {
            mirrored.clone_from(own);
            seen
        } else {
            job(compiled, &other_inputs, other_drive.as_ref(), mirrored)?
        };
        let (a, b) = (side.index(), side.other().index());
        seen.axle.wheels[b] = other.axle.wheels[a].map(|state| state.mirrored());
        seen.load[b] = other.load[a];
        seen.rates[b] = other.rates[a].map(WheelRate::mirrored);
        if seen.friction != other.friction {
            seen.friction = Some(Grasp::Mixed);
        }
        if let (Some(own), Some(other)) = (&mut seen.axle.compliance, other.axle.compliance) {
            let image = other.mirrored(side);
            own.matrix
                .fixed_view_mut::<6, 6>(6 * b, 6 * b)
                .copy_from(&image.matrix.fixed_view::<6, 6>(6 * b, 6 * b));
            own.present = [true; 2];
        }
        Ok(seen)
    }
}

impl WheelRate {
    /// The mean; `None` of nothing.
    pub(super) fn mean(all: &[Self]) -> Option<Self> {
        let share = 1.0 / all.len() as f64;
        (!all.is_empty()).then(|| Self {
            motion: all.iter().map(|rate| rate.motion).sum::<Vec6>() * share,
            load: all.iter().map(|rate| rate.load).sum::<f64>() * share,
        })
    }

    fn mirrored(self) -> Self {
        let m = &self.motion;
        Self {
            motion: Vec6::new(m[0], -m[1], m[2], -m[3], m[4], -m[5]),
            load: self.load,
        }
    }
}

impl Compiled {
    fn new(bench: &Bench<'_>, rigged: Rigged) -> Result<Self, BenchError> {
        let lowered = Model::lower_with(&rigged.dataset, bench.files);
        let errors = |all: &[Diagnostic]| -> Vec<Diagnostic> {
            let bad = all.iter().filter(|d| d.severity == Severity::Error);
            bad.cloned().collect()
        };
        let found = errors(&lowered.diagnostics);
        if !found.is_empty() {
            return Err(BenchError::Deck(found));
        }
        let model = lowered.value;
        let refuse = |error: &dyn std::fmt::Display| {
            let message = error.to_string();
            BenchError::Deck(vec![Diagnostic::error(Code::NotSolvedNatively, message)])
        };
        // In statics FRICTION is refused. Here it creeps from one equilibrium to the next.
        let mut rest = model.clone();
        let mut creeping = Vec::new();
        for friction in &mut rest.frictions {
            if std::mem::take(&mut friction.in_statics) {
                creeping.push(friction.header.id);
            }
        }
        let mut system = compile(&rest).map_err(|error| refuse(&error))?;
        system.let_creep(&creeping, bench.config.sliding_with);
        let slot = |kind: &str, id: u32| {
            let address = Address {
                kind: kind.to_string(),
                id: Some(id),
                argument: None,
                index: None,
            };
            crate::backend::slot(&system, &address).map_err(|error| refuse(&error))
        };
        let mut wheels = Vec::new();
        for (ids, found) in rigged.wheels.iter().zip(&bench.wheels) {
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
                part: PartIx(found.part),
                centre: marker(ids.centre),
                ground: marker(ids.ground),
                loads: [loads[0], loads[1], loads[2], loads[3]],
                patch: [loads[4], loads[5]],
                motion,
            });
        }
        let steering = match &bench.config.steering_drive {
            None => None,
            Some(at) => {
                let complain = |why: &dyn std::fmt::Display| {
                    let message = why.to_string();
                    let found = bench.config.complain(at, Code::UnknownTarget, message);
                    BenchError::Deck(vec![found])
                };
                // With a free steering what drives it may be left out.
                let there = Address::parse(&at.text, &rigged.dataset);
                match there {
                    Ok(address) => Some(
                        crate::backend::slot(&system, &address)
                            .map_err(|error| complain(&error))?,
                    ),
                    Err(why) => match Address::parse(&at.text, bench.dataset) {
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
            system,
        })
    }

    fn parameters(&self, inputs: &Inputs) -> Parameters {
        let mut parameters = self.system.parameters();
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
            // A number of the deck is changed by the value, a function is replaced by it.
            let own = parameters.get(slot);
            parameters.set(slot, if own.is_finite() { own + value } else { value });
        }
        parameters
    }

    /// Finds the equilibrium; with it come the numbers of theta, and how many harmless free motions there are.
    fn solve(
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
            let seen = |name: &crate::system::Name| {
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

    fn observe(
        &mut self,
        (config, found): (&Config, &[FoundWheel]),
        (inputs, drive): (&Inputs, Option<&Drive>),
        (state, rubs): (&mut State, bool),
        at: &str,
    ) -> Result<Observation, BenchError> {
        let (parameters, named) = self.solve(inputs, state, at)?;
        let derivatives = Derivatives::of(self, config, (&parameters, state), (drive, found))
            .map_err(|why| BenchError::NoEquilibrium {
                at: at.to_string(),
                why: Box::new(why),
            })?;
        if derivatives.deficiency > named {
            // The factors of the last iteration did not show it yet. New ones of the equilibrium itself do, and name it.
            self.solver.forget(&self.system);
            self.solve(inputs, state, at)?;
        }
        // Round-off may hide a free motion from the factors, but not from what they answer.
        let unit = (self.model.units.length.si, self.model.units.force.si);
        if let Some(motion) = derivatives.compliance.and_then(|c| c.free_motion(unit)) {
            return Err(BenchError::Free {
                at: at.to_string(),
                motion,
            });
        }
        let mut axle = AxleState {
            wheels: [None; 2],
            normal: Vec3::z(),
            compliance: derivatives.compliance,
        };
        let friction = if rubs {
            self.system.creep_on(&parameters, state, &mut self.scratch)
        } else {
            self.system.creeps().then_some(Grasp::Released)
        };
        let mut load = [0.0; 2];
        let mut rates = [None; 2];
        for (n, (wheel, found)) in self.wheels.iter().zip(found).enumerate() {
            let k = wheel.side.index();
            load[k] = inputs.loads[k][2] + derivatives.reactions[n];
            rates[k] = derivatives.rates.get(n).copied();
            let now = self.wheel(config, state, wheel);
            let design = Wheel {
                side: wheel.side,
                centre: config.frame.vector(&found.design.p),
                spin: config.frame.vector(&found.design.R.column(2).into()),
                turn: nalgebra::Matrix3::identity(),
            };
            let radius = config.tyre.map(|tyre| {
                [
                    contact::loaded_radius(tyre.radius, load[k], tyre.stiffness),
                    tyre.radius,
                ]
            });
            axle.wheels[k] = Some(WheelState {
                wheel: now,
                design,
                radius,
                axis: self
                    .geometric_axis(config, state, found)
                    .or_else(|| derivatives.axes.get(n).copied().flatten()),
            });
        }
        Ok(Observation {
            axle,
            load,
            rates,
            friction,
        })
    }

    fn place(&self, state: &State, marker: MarkerIx) -> Pose {
        let frame = &self.model.markers[marker.0];
        state.poses[frame.part.0].compose(&Pose {
            p: frame.qp,
            R: frame.R,
        })
    }

    fn wheel(&self, config: &Config, state: &State, wheel: &Fitted) -> Wheel {
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

    fn geometric_axis(
        &self,
        config: &Config,
        state: &State,
        found: &FoundWheel,
    ) -> Option<SteerAxis> {
        if !matches!(config.axis_method, AxisMethod::Geometric | AxisMethod::Any) {
            return None;
        }
        let [lower, upper] = found.steer_axis?;
        // The rig's markers come behind those of the deck, which keep their index.
        let at = |marker| config.frame.vector(&self.place(state, marker).p);
        SteerAxis::through(&at(lower), &at(upper))
    }
}

impl Chain {
    /// Goes on from where another chain of the same deck is, whatever that held. Joints do not rub yet.
    pub fn start_at(&mut self, other: &Self) {
        for (own, other) in self.states.iter_mut().zip(&other.states) {
            own.poses.clone_from(&other.poses);
        }
    }
}
