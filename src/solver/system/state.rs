use crate::function::{Piece, Reference, half_width};
use crate::mechanics::{Mat3, Pose, Vec3};

/// Velocity of a part, or its acceleration: of the origin and of the rotation, ground axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Rates {
    /// Of the part's origin.
    pub linear: Vec3,
    /// Of its rotation.
    pub angular: Vec3,
}

impl Rates {
    /// At rest.
    pub(crate) const fn zero() -> Self {
        Self {
            linear: Vec3::new(0.0, 0.0, 0.0),
            angular: Vec3::new(0.0, 0.0, 0.0),
        }
    }
}

/// Where a MOTION that prescribes a rate stands: the constants of integration, moved on from time to time.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Driven {
    /// Time at which it has these values.
    pub time: f64,
    /// The displacement.
    pub value: f64,
    /// Its rate; of a velocity motion not used.
    pub rate: f64,
}

/// Where a friction stands: what of its creep lies behind, and from where it goes on.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct StictionState {
    /// It sticks: the creep counts.
    pub sticking: bool,
    /// The creep at the anchor, by directions.
    pub creep: Vec3,
    /// The displacement along zj there.
    pub place: f64,
    /// The rotation of I in J there.
    pub turn: Mat3,
    /// The displacement when the joint was first assembled.
    pub first: Option<f64>,
}

impl StictionState {
    /// Nothing sticks, and nothing was assembled yet.
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

/// What one solve changes: cloneable, so that the next solve starts from the last answer.
#[derive(PartialEq, Debug)]
pub struct State {
    /// TIME.
    pub time: f64,
    /// MODE: 5 in statics, 6 in quasi-statics (guide/formats.md 3.1).
    pub mode: i32,
    /// Pose of each part of the model in ground, by [`PartIx`](crate::model::PartIx); ground is the identity.
    pub poses: Vec<Pose>,
    /// One per scalar constraint equation. The reaction on I is minus multiplier times the equation's gradient.
    pub multipliers: Vec<f64>,
    /// VARIABLE values, in the order of the model.
    pub variables: Vec<f64>,
    /// DIFF states, then the states of LSE, GSE, TFSISO; held ones too.
    pub states: Vec<f64>,
    /// Which constraint equations are redundant and take part in nothing; empty before the first analysis.
    pub redundant: Vec<bool>,
    /// AX, AY, AZ of each pair at the last equilibrium: turns are counted from here.
    pub pair_angles: Vec<Vec3>,
    /// The same for angle measures of functions.
    pub measure_angles: Vec<Reference>,
    /// Velocity of each part; empty at rest, as in statics.
    pub velocities: Vec<Rates>,
    /// Acceleration of each part; empty at rest.
    pub accelerations: Vec<Rates>,
    /// Time derivative of each dynamic state; empty at rest.
    pub state_rates: Vec<f64>,
    /// MOTIONs that prescribe a velocity or an acceleration, in the order of the model.
    pub driven: Vec<Driven>,
    /// Where each friction of a joint stands.
    pub grips: Vec<StictionState>,
    /// What SENVAL gives, in the order of the model's SENSORs; the session sets it when a sensor fires.
    pub sensors: Vec<f64>,
    /// The pieces that IMPACTs, BISTOPs and IFs are held on within a step of a motion; empty elsewhere: all are as their arguments have them.
    pub pieces: Vec<Piece>,
}

impl State {
    /// Functions are as their arguments have them; those held between two sides stay, which have no value of their own there.
    pub(crate) fn clear_branches(&mut self) {
        for piece in &mut self.pieces {
            *piece = piece.filter(|_| half_width(*piece).is_some());
        }
    }

    /// No parts at all: a place holder that costs nothing.
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

    /// True if its rates count; in statics nothing moves.
    pub fn moves(&self) -> bool {
        !self.velocities.is_empty()
    }

    /// Gives everything a rate, zero where it has none yet.
    pub fn set_moving(&mut self) {
        self.velocities.resize(self.poses.len(), Rates::zero());
        self.accelerations.resize(self.poses.len(), Rates::zero());
        self.state_rates.resize(self.states.len(), 0.0);
    }

    /// Brings everything to rest.
    pub fn set_at_rest(&mut self) {
        self.velocities.clear();
        self.accelerations.clear();
        self.state_rates.clear();
        for grip in &mut self.grips {
            grip.sticking = false;
        }
    }

    /// The angles that turns are counted from, one after the other; those that functions measure with their normals.
    pub fn turns(&self) -> Vec<f64> {
        let pairs = self.pair_angles.iter().flat_map(|angles| angles.iter());
        let measured = self.measure_angles.iter().flat_map(|from| {
            let normal = from.normal.iter().copied();
            std::iter::once(from.angle).chain(normal)
        });
        pairs.copied().chain(measured).collect()
    }

    /// Counts turns from these angles; those of another model are left.
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

    /// The answer of this state, without what only the solver needs.
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

    /// Keeps the memory: a solve copies states in every iteration.
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

/// Where all parts are at rest: what every solver, ours or an external one, has to say.
#[derive(Clone, PartialEq, Debug)]
pub struct Equilibrium {
    /// TIME of the step.
    pub time: f64,
    /// Pose of each part of the model in ground, by [`PartIx`](crate::model::PartIx).
    pub poses: Vec<Pose>,
}
