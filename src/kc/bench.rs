//! Equilibria of a deck on the rig: states of the axle, its compliance and its tangents.

use std::collections::BTreeMap;

use super::axle::{AxleState, WheelState};
use super::bench_error::BenchError;
use super::compiled::Compiled;
use super::config::Config;
use super::deck_change::DeckChange;
use super::derivatives::Derivatives;
use super::inputs::{Drive, Inputs};
use super::rig::{FoundWheel, Variant, rigged};
use super::test_settings::Hold;
use super::wheel_rate::WheelRate;
use super::{Wheel, contact};
use admire_solver::mechanics::Vec3;
use admire_solver::model::{MarkerIx, Model};
use admire_solver::statics::{Balance, Probe};
use admire_solver::system::{State, StickSlipState};
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::files::Files;
use admire_syntax::units::Units;
use admire_syntax::{Address, Dataset};

/// Solved state of the axle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Observation {
    /// Wheels and compliance.
    pub axle: AxleState,
    /// Vertical load of each wheel (left, right).
    pub load: [f64; 2],
    /// Motion and vertical load of each wheel (left, right) per unit of the test's variable. `None` for a missing wheel, or without
    /// tangents.
    pub rates: [Option<WheelRate>; 2],
    /// Stick-slip state of the joints with friction; `None` if no joint has friction.
    pub friction: Option<StickSlipState>,
}

/// Deck on the rig, with its compiled variants.
#[derive(Debug)]
pub struct Bench<'a> {
    /// Configuration from `kc.toml`.
    pub config: &'a Config,
    dataset: &'a Dataset,
    files: &'a Files,
    model: &'a Model,
    /// Wheels found in the deck.
    pub wheels: Vec<FoundWheel>,
    variants: BTreeMap<Variant, Compiled>,
    directions: Vec<DeckChange>,
    turned: Vec<(MarkerIx, Vec3)>,
    probes: Vec<Probe>,
}

/// State of the axle, with its derivatives along the changes given to [`Bench::differentiate`].
#[derive(Clone, Debug)]
pub(crate) struct Observed {
    pub seen: Observation,
    /// Motion and load of the wheels per unit of each change.
    pub changes: Vec<WheelChanges>,
    pub probed: Probed,
}

/// Values of the probes given to [`Bench::probe`] in one state, in units of the deck and radians.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Probed {
    /// Value of each probe; NaN for a force whose element the rig has removed.
    pub values: Vec<f64>,
    /// Derivative of each probe along each change of [`Bench::differentiate`]; empty without changes.
    pub changes: Vec<Vec<f64>>,
}

/// Motion and vertical load of each wheel (left, right) per unit of a change; `None` for a missing wheel.
pub type WheelChanges = [Option<WheelRate>; 2];

/// Last solved states of a sweep, for the deck and for its mirror image. The next solve starts from them.
#[derive(Clone, Debug)]
pub struct WarmStart {
    states: [State; 2],
    /// True once friction acts in the joints. Before that, joints carry no friction force.
    rubs: bool,
}

impl<'a> Bench<'a> {
    /// Creates the bench and finds the wheels named in the configuration.
    ///
    /// # Errors
    /// One diagnostic for each wheel whose markers or spin axis in `kc.toml` are missing or unsuitable.
    pub fn new(
        config: &'a Config,
        dataset: &'a Dataset,
        files: &'a Files,
        model: &'a Model,
    ) -> Result<Self, Vec<Diagnostic>> {
        Ok(Self {
            config,
            dataset,
            files,
            model,
            wheels: super::rig::wheels(config, dataset, model)?,
            variants: BTreeMap::new(),
            directions: Vec::new(),
            turned: Vec::new(),
            probes: Vec::new(),
        })
    }

    /// Adds probes that are read in every later state. Their values are in [`Sample::probed`](super::Sample::probed). In a deck with one
    /// wheel and a mirror image, they are read on the deck itself.
    pub fn probe(&mut self, probes: Vec<Probe>) {
        // The functions of probes are part of the equations.
        self.variants.clear();
        self.probes = probes;
    }

    /// Rotates markers on their parts in every later state. Each rotation vector is in radians and in the axes of the marker. Wheel centres
    /// and spin axes are unaffected, because the rig has its own markers for them.
    pub fn turn(&mut self, turned: Vec<(MarkerIx, Vec3)>) {
        for compiled in self.variants.values_mut() {
            compiled.turned.clone_from(&turned);
        }
        self.turned = turned;
    }

    /// Requests derivatives along changes of the deck in every later state. [`Sample::changes`](super::Sample::changes) holds the
    /// derivatives.
    ///
    /// The derivatives are exact, from the tangent stiffness. A number counts as having no effect if the rig removes it, or if the solver cannot
    /// differentiate with respect to it. A change that moves the marker of a wheel centre or of a spin axis is not included, because the rig has
    /// its own markers for them.
    pub fn differentiate(&mut self, directions: Vec<DeckChange>) {
        for compiled in self.variants.values_mut() {
            compiled.direct(&directions);
        }
        self.directions = directions;
    }

    /// Returns the number of changes along which states are differentiated.
    pub(crate) fn directions(&self) -> usize {
        self.directions.len()
    }

    /// Returns true if the solver can differentiate an equilibrium with respect to the number at an address.
    ///
    /// # Errors
    /// [`BenchError::Deck`] if the deck cannot be solved.
    pub fn has_derivative(&mut self, address: &Address) -> Result<bool, BenchError> {
        let compiled = self.variant(Variant::of(Hold::Height, true))?;
        Ok(compiled.system.catalogue().slot(address).is_some())
    }

    /// Returns the worst imbalance of forces and torques on a part over all equilibria found so far.
    pub(crate) fn balance(&self) -> Balance {
        let mut worst = Balance::default();
        for compiled in self.variants.values() {
            if let Some(found) = compiled.solver.worst_balance() {
                worst.or_worse(found);
            }
        }
        worst
    }

    /// Returns the units of the deck.
    pub(crate) fn units(&self) -> &'a Units {
        &self.model.units
    }

    /// Returns the configuration.
    pub(crate) fn config(&self) -> &'a Config {
        self.config
    }

    /// Returns the deck without the rig.
    pub(crate) fn dataset(&self) -> &'a Dataset {
        self.dataset
    }

    /// Returns the compiled form of a variant of the rigged deck. The variant is compiled on first use.
    ///
    /// # Errors
    /// [`BenchError::Deck`] if the deck cannot be solved.
    pub(crate) fn variant(&mut self, variant: Variant) -> Result<&mut Compiled, BenchError> {
        if !self.variants.contains_key(&variant) {
            let rigged = rigged(self.config, self.dataset, self.model, &self.wheels, variant)
                .map_err(|why| BenchError::Deck(vec![why]))?;
            let own = (self.wheels.as_slice(), self.probes.as_slice());
            let mut compiled = Compiled::new(self.config, self.dataset, self.files, own, rigged)?;
            compiled.direct(&self.directions);
            compiled.turned.clone_from(&self.turned);
            self.variants.insert(variant, compiled);
        }
        Ok(self
            .variants
            .get_mut(&variant)
            .expect("compiled just above"))
    }

    /// Creates the warm start of a chain of equilibria, at the design position.
    ///
    /// # Errors
    /// As [`Bench::variant`].
    pub fn chain(&mut self, variant: Variant) -> Result<WarmStart, BenchError> {
        let state = self.variant(variant)?.system.state();
        Ok(WarmStart {
            states: [state.clone(), state],
            rubs: false,
        })
    }

    /// Turns on friction in the joints. The present position becomes the reference position of the joints: they stick there without
    /// friction force.
    ///
    /// # Errors
    /// As [`Bench::variant`].
    pub(crate) fn enable_friction(
        &mut self,
        variant: Variant,
        chain: &mut WarmStart,
    ) -> Result<(), BenchError> {
        let compiled = self.variant(variant)?;
        let parameters = compiled.own_parameters();
        for state in &mut chain.states {
            let scratch = &mut compiled.scratch;
            compiled
                .system
                .advance_friction(&parameters, state, scratch);
        }
        chain.rubs = true;
        Ok(())
    }

    /// Solves the equilibrium for `inputs`, starting from the last state of the chain, without computing any wheel data.
    ///
    /// # Errors
    /// As [`Bench::observe`].
    pub(crate) fn settle(
        &mut self,
        variant: Variant,
        chain: &mut WarmStart,
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
                compiled
                    .system
                    .advance_friction(&parameters, state, scratch);
            }
            Ok(())
        };
        settle(inputs, own)?;
        if mirror {
            settle(&inputs.mirrored(), other)?;
        }
        Ok(())
    }

    /// Solves the equilibrium for `inputs`, starting from the last state of the chain, and evaluates the wheels. With `drive`, tangents are
    /// computed too.
    ///
    /// # Errors
    /// [`BenchError`] if there is no equilibrium, or if a wheel has a zero-stiffness motion. The error message contains `at`, the name of
    /// the test and point.
    pub fn observe(
        &mut self,
        variant: Variant,
        chain: &mut WarmStart,
        inputs: &Inputs,
        drive: Option<&Drive>,
        at: &str,
    ) -> Result<Observation, BenchError> {
        let found = self.observe_along(variant, chain, inputs, (drive, &[]), at)?;
        Ok(found.seen)
    }

    /// Does the same as [`Bench::observe`], and differentiates the state along the changes of [`Bench::differentiate`]. `along` holds the
    /// change of the inputs per unit of each change; no derivatives are computed if it is empty.
    ///
    /// # Errors
    /// As [`Bench::observe`].
    pub(crate) fn observe_along(
        &mut self,
        variant: Variant,
        chain: &mut WarmStart,
        inputs: &Inputs,
        (drive, along): (Option<&Drive>, &[Drive]),
        at: &str,
    ) -> Result<Observed, BenchError> {
        let (config, wheels, rubs) = (self.config, self.wheels.clone(), chain.rubs);
        let job = |compiled: &mut Compiled,
                   inputs: &Inputs,
                   drives: (Option<&Drive>, &[Drive]),
                   state: &mut State| {
            compiled.observe((config, &wheels), (inputs, drives), (state, rubs), at)
        };
        let compiled = self.variant(variant)?;
        let [own, mirrored] = &mut chain.states;
        let mut found = job(compiled, inputs, (drive, along), own)?;
        if !config.mirror {
            return Ok(found);
        }
        let Observed { seen, changes, .. } = &mut found;
        let side = wheels[0].side;
        let other_inputs = inputs.mirrored();
        let other_drive = drive.map(Drive::mirrored);
        // In a symmetric load case the missing wheel is the mirror image of the solved wheel, and needs no solve of its own.
        let k = side.index();
        let alike = own.grips == mirrored.grips
            && other_inputs.height[k] == inputs.height[k]
            && other_inputs.loads[k] == inputs.loads[k]
            && other_inputs.steer.unwrap_or(0.0) == inputs.steer.unwrap_or(0.0)
            && other_drive.map(|d| (d.height[k], d.loads[k], d.steer))
                == drive.map(|d| (d.height[k], d.loads[k], d.steer))
            && along.iter().all(|d| {
                let other = d.mirrored();
                (d.height[k], d.loads[k], d.steer) == (other.height[k], other.loads[k], other.steer)
            });
        let (other, other_changes) = if alike {
            mirrored.clone_from(own);
            (*seen, changes.clone())
        } else {
            let other_along: Vec<Drive> = along.iter().map(Drive::mirrored).collect();
            let drives = (other_drive.as_ref(), other_along.as_slice());
            let other = job(compiled, &other_inputs, drives, mirrored)?;
            (other.seen, other.changes)
        };
        let (a, b) = (side.index(), side.other().index());
        seen.axle.wheels[b] = other.axle.wheels[a].map(|state| state.mirrored());
        seen.load[b] = other.load[a];
        seen.rates[b] = other.rates[a].map(WheelRate::mirrored);
        for (own, other) in changes.iter_mut().zip(&other_changes) {
            own[b] = other[a].map(WheelRate::mirrored);
        }
        if seen.friction != other.friction {
            seen.friction = Some(StickSlipState::Mixed);
        }
        if let (Some(own), Some(other)) = (&mut seen.axle.compliance, other.axle.compliance) {
            let image = other.mirrored(side);
            own.matrix
                .fixed_view_mut::<6, 6>(6 * b, 6 * b)
                .copy_from(&image.matrix.fixed_view::<6, 6>(6 * b, 6 * b));
            own.present = [true; 2];
        }
        Ok(found)
    }
}

impl Compiled {
    fn observe(
        &mut self,
        (config, found): (&Config, &[FoundWheel]),
        (inputs, drives): (&Inputs, (Option<&Drive>, &[Drive])),
        (state, rubs): (&mut State, bool),
        at: &str,
    ) -> Result<Observed, BenchError> {
        let (parameters, named) = self.solve(inputs, state, at)?;
        let refuse = |why| BenchError::NoEquilibrium {
            at: at.to_string(),
            why: Box::new(why),
        };
        let derivatives =
            Derivatives::of(self, config, &parameters, state, drives, found).map_err(refuse)?;
        let here = (&self.system, &parameters, &*state);
        let values = self.probes.values(here, &mut self.scratch);
        let values = values.map_err(|why| refuse(why.into()))?;
        if derivatives.deficiency > named {
            // The factors of the last iteration missed a free motion. Factoring again at the equilibrium itself reveals and names it.
            self.solver.forget(&self.system);
            self.solve(inputs, state, at)?;
        }
        // Round-off may hide a free motion from the factors. It still shows as a huge entry of the compliance.
        let units = &self.model.units;
        let motion = derivatives
            .compliance
            .and_then(|c| c.free_motion(units.length.si, units.force.si));
        if let Some(motion) = motion {
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
            self.system
                .advance_friction(&parameters, state, &mut self.scratch)
        } else {
            self.system.creeps().then_some(StickSlipState::Released)
        };
        let mut load = [0.0; 2];
        let mut rates = [None; 2];
        let mut changes = vec![[None; 2]; derivatives.along.len()];
        for (n, (wheel, found)) in self.wheels.iter().zip(found).enumerate() {
            let k = wheel.side.index();
            load[k] = inputs.loads[k][2] + derivatives.reactions[n];
            rates[k] = derivatives.rates.get(n).copied();
            for (change, along) in changes.iter_mut().zip(&derivatives.along) {
                change[k] = along.get(n).copied();
            }
            let now = self.wheel(config, state, wheel);
            let design = Wheel {
                side: wheel.side,
                centre: config.frame.vector(&found.design.p),
                spin: config.frame.vector(&found.design.R.column(2).into()),
                turn: nalgebra::Matrix3::identity(),
            };
            let radius = config.tyre.map(|tyre| {
                let now = contact::loaded_radius(&tyre, load[k], &now.spin, &axle.normal);
                [now, tyre.radius]
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
        let seen = Observation {
            axle,
            load,
            rates,
            friction,
        };
        Ok(Observed {
            seen,
            changes,
            probed: Probed {
                values,
                changes: derivatives.probes,
            },
        })
    }
}

impl WarmStart {
    /// Copies the poses from another chain of the same deck. The friction state of that chain is not copied, and friction stays off.
    pub fn start_at(&mut self, other: &Self) {
        for (own, other) in self.states.iter_mut().zip(&other.states) {
            own.poses.clone_from(&other.poses);
        }
    }
}
