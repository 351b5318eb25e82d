use crate::function::{Piece, Reference, half_width};
use crate::mechanics::{Mat3, Pose, Vec3};

/// Velocities or accelerations of a part, in ground axes: linear (of its origin) and angular.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PartRates {
    /// Linear velocity or acceleration of the part's origin.
    pub linear: Vec3,
    /// Angular velocity or acceleration.
    pub angular: Vec3,
}

impl PartRates {
    /// Returns zero rates.
    pub(crate) const fn zero() -> Self {
        Self {
            linear: Vec3::new(0.0, 0.0, 0.0),
            angular: Vec3::new(0.0, 0.0, 0.0),
        }
    }
}

/// Integration constants of a MOTION that prescribes a velocity or acceleration. They are advanced during the simulation.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Driven {
    /// Time to which these values refer.
    pub time: f64,
    /// Displacement at that time.
    pub value: f64,
    /// Rate of the displacement at that time; unused for a velocity motion.
    pub rate: f64,
}

/// State of a joint friction: the creep and the joint position at the anchor. The anchor is the end of the last time step.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct StictionState {
    /// Whether the surfaces stick. Only then does the creep count.
    pub sticking: bool,
    /// Creep at the anchor, one component per sliding direction.
    pub creep: Vec3,
    /// Displacement along zj at the anchor.
    pub place: f64,
    /// Rotation of I in J at the anchor.
    pub turn: Mat3,
    /// Displacement along zj at the first assembly of the joint; `None` before the first assembly.
    pub first: Option<f64>,
}

impl StictionState {
    /// Returns the state of a friction before the first assembly: sliding, without creep.
    pub(crate) fn none() -> Self {
        Self {
            sticking: false,
            creep: Vec3::zeros(),
            place: 0.0,
            turn: Mat3::identity(),
            first: None,
        }
    }
}

/// Values that a solver changes. The state can be cloned, so that the next solution starts from the last one.
#[derive(PartialEq, Debug)]
pub struct State {
    /// Simulation time, TIME.
    pub time: f64,
    /// Analysis mode, MODE: 5 in statics, 6 in quasi-statics (guide/formats.md 3.1).
    pub mode: i32,
    /// Pose of each part in ground, by [`PartIx`](crate::model::PartIx); ground is the identity.
    pub poses: Vec<Pose>,
    /// Lagrange multipliers, one per scalar constraint equation. The reaction on I is minus the multiplier times the equation's gradient.
    pub multipliers: Vec<f64>,
    /// Values of the VARIABLEs, in the order of the model.
    pub variables: Vec<f64>,
    /// States of the DIFFs, then the states of LSE and TFSISO, including states that are held constant.
    pub states: Vec<f64>,
    /// Whether each constraint equation is redundant and therefore ignored; empty before the first analysis.
    pub redundant: Vec<bool>,
    /// AX, AY, AZ of each marker pair at the last equilibrium: the references for counting full turns.
    pub pair_angles: Vec<Vec3>,
    /// Reference angles of the angle measures in functions, taken at the last equilibrium.
    pub measure_angles: Vec<Reference>,
    /// Velocity of each part; empty at rest, as in statics.
    pub velocities: Vec<PartRates>,
    /// Acceleration of each part; empty at rest.
    pub accelerations: Vec<PartRates>,
    /// Time derivative of each dynamic state; empty at rest.
    pub state_rates: Vec<f64>,
    /// Integration constants of MOTIONs that prescribe a velocity or an acceleration, in the order of the model.
    pub driven: Vec<Driven>,
    /// State of each joint friction.
    pub grips: Vec<StictionState>,
    /// Values of SENVAL, in the order of the model's SENSORs. The session sets them when a sensor triggers.
    pub sensors: Vec<f64>,
    /// Pieces on which piecewise functions are held within an integration step. Empty outside a step: the arguments then select the pieces.
    pub pieces: Vec<Piece>,
}

impl State {
    /// Releases the held pieces, so that the arguments select the pieces again. Functions held between two sides stay held, because they
    /// have no value of their own at the jump.
    pub(crate) fn clear_branches(&mut self) {
        for piece in &mut self.pieces {
            *piece = piece.filter(|_| half_width(*piece).is_some());
        }
    }

    /// Returns a placeholder state without parts, which allocates nothing.
    pub(crate) const fn empty() -> Self {
        Self {
            time: 0.0,
            mode: 5,
            poses: Vec::new(),
            multipliers: Vec::new(),
            variables: Vec::new(),
            states: Vec::new(),
            redundant: Vec::new(),
            pair_angles: Vec::new(),
            measure_angles: Vec::new(),
            velocities: Vec::new(),
            accelerations: Vec::new(),
            state_rates: Vec::new(),
            driven: Vec::new(),
            grips: Vec::new(),
            sensors: Vec::new(),
            pieces: Vec::new(),
        }
    }

    /// Returns whether the state has velocities and accelerations. It has none in statics.
    pub fn moves(&self) -> bool {
        !self.velocities.is_empty()
    }

    /// Allocates velocities, accelerations and state rates. Existing values are kept, new ones are zero.
    pub fn set_moving(&mut self) {
        self.velocities.resize(self.poses.len(), PartRates::zero());
        self.accelerations
            .resize(self.poses.len(), PartRates::zero());
        self.state_rates.resize(self.states.len(), 0.0);
    }

    /// Removes all velocities, accelerations and state rates, and releases sticking friction.
    pub fn set_at_rest(&mut self) {
        self.velocities.clear();
        self.accelerations.clear();
        self.state_rates.clear();
        for grip in &mut self.grips {
            grip.sticking = false;
        }
    }

    /// Returns the reference angles for counting full turns, in one list. Angles measured by functions are followed by their normals.
    pub fn turns(&self) -> Vec<f64> {
        let pairs = self.pair_angles.iter().flat_map(|angles| angles.iter());
        let measured = self.measure_angles.iter().flat_map(|from| {
            let normal = from.normal.iter().copied();
            std::iter::once(from.angle).chain(normal)
        });
        pairs.copied().chain(measured).collect()
    }

    /// Sets the reference angles for counting full turns. A list of the wrong length, which comes from another model, is ignored.
    pub fn set_turns(&mut self, turns: &[f64]) {
        let pairs = 3 * self.pair_angles.len();
        if turns.len() == pairs + 4 * self.measure_angles.len() {
            for (angles, from) in self.pair_angles.iter_mut().zip(turns.chunks_exact(3)) {
                *angles = Vec3::from_column_slice(from);
            }
            let measured = turns[pairs..].chunks_exact(4);
            for (reference, from) in self.measure_angles.iter_mut().zip(measured) {
                reference.angle = from[0];
                reference.normal = Vec3::from_column_slice(&from[1..]);
            }
        }
    }

    /// Returns the time and the part poses of this state, without the solver's internal data.
    pub fn equilibrium(&self) -> Equilibrium {
        Equilibrium {
            time: self.time,
            poses: self.poses.clone(),
        }
    }
}

impl Clone for State {
    fn clone(&self) -> Self {
        let mut new = Self::empty();
        new.clone_from(self);
        new
    }

    /// Copies without new allocations, because a solver copies states in every iteration.
    fn clone_from(&mut self, other: &Self) {
        self.time = other.time;
        self.mode = other.mode;
        self.poses.clone_from(&other.poses);
        self.multipliers.clone_from(&other.multipliers);
        self.variables.clone_from(&other.variables);
        self.states.clone_from(&other.states);
        self.redundant.clone_from(&other.redundant);
        self.pair_angles.clone_from(&other.pair_angles);
        self.measure_angles.clone_from(&other.measure_angles);
        self.velocities.clone_from(&other.velocities);
        self.accelerations.clone_from(&other.accelerations);
        self.state_rates.clone_from(&other.state_rates);
        self.driven.clone_from(&other.driven);
        self.grips.clone_from(&other.grips);
        self.sensors.clone_from(&other.sensors);
        self.pieces.clone_from(&other.pieces);
    }
}

/// Equilibrium positions of all parts: the result that every solver, built-in or external, returns.
#[derive(Clone, PartialEq, Debug)]
pub struct Equilibrium {
    /// Time of the step, TIME.
    pub time: f64,
    /// Pose of each part in ground, by [`PartIx`](crate::model::PartIx).
    pub poses: Vec<Pose>,
}
