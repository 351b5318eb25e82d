//! The resolved model: typed, named objects with values in the dataset's units and angles in radians.
//!
//! The module is independent of the text of the dataset. Each object keeps its `origin`, the index of its statement. The bytes of a number
//! in the file are found through its [`Address`](crate::syntax) in the dataset.

mod constraint;
mod convert_units;
mod data;
mod extract;
mod force;
mod frame;
mod friction;
pub mod lint;
mod lower;
mod object;
mod settings;
pub mod summary;
mod unsolved;
mod user_force;

pub use constraint::MotionAxis;
pub use constraint::MotionOrder;
pub use constraint::PrimitiveKind;
pub use constraint::{Coupler, Joint, JointKind, Motion};
pub(crate) use constraint::{CouplerKind, Gcon, Gear, Primitive};
pub use convert_units::convert_units;
pub use data::ArrayKind;
pub use data::LinearStates;
pub use data::SensorCompare;
pub(crate) use data::{ArrayData, Diff, PlantPort, Spline, StringData};
pub use data::{Request, RequestKind, Sensor, Variable};
pub use extract::extract;
pub use force::Sforce;
pub use force::SforceKind;
pub use force::SpringDamper;
pub use force::VectorForceKind;
pub(crate) use force::law_arguments;
pub use force::{Bushing, ElasticPair, PairForce, SpringKind};
pub(crate) use force::{Nforce, VectorForce};
pub use frame::InitialVelocity;
pub use frame::Marker;
pub use frame::Relative;
pub use frame::{MarkerIx, Orientation, Part, PartIx, PartKind};
pub use friction::Friction;
pub(crate) use friction::FrictionInputs;
pub use lower::{Definitions, lower};
pub use settings::IntegratorSettings;
pub use settings::KinematicsSettings;
pub use settings::ResultsSettings;
pub(crate) use settings::{EquilibriumSettings, OutputSettings, StaticMethod};
pub use unsolved::Ignore;
pub(crate) use unsolved::Unsolved;
pub use unsolved::left_out_warning;
pub(crate) use unsolved::{effect_of, may_be_ignored};
pub use user_force::replace_user_forces;

use crate::mechanics::{Pose, Vec3};
use admire_syntax::units::Units;

/// Data common to all objects of a model.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Header {
    /// Id of the statement.
    pub id: u32,
    /// Adams/View name. If the file gives no name, this is kind and id, such as `PART_2`.
    pub name: String,
    /// Index of the object's statement in its dataset.
    pub origin: usize,
    /// Whether the object is active; false after DEACTIVATE.
    pub active: bool,
}

/// FUNCTION of an object.
#[derive(Clone, PartialEq, Debug)]
pub enum Function {
    /// Parsed expression, shared with the dataset. It includes the text as written, without continuation marks.
    Expression(std::sync::Arc<admire_syntax::Expression>),
    /// `USER(...)`: call of a subroutine that only real ADAMS can run, with its text as written.
    User(String),
}

/// Resolved model of one dataset.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Model {
    /// Title: the first line of the dataset.
    pub title: String,
    /// Units, including the units consistency factor.
    pub units: Units,
    /// Acceleration of gravity in ground axes.
    pub gravity: Vec3,
    /// Bodies (parts, point masses, flexible bodies) in order of appearance. Exactly one is ground.
    pub parts: Vec<Part>,
    /// Markers in order of appearance.
    pub markers: Vec<Marker>,
    /// JOINT statements.
    pub joints: Vec<Joint>,
    /// JPRIM statements.
    pub primitives: Vec<Primitive>,
    /// COUPLER statements.
    pub couplers: Vec<Coupler>,
    /// GEAR statements.
    pub gears: Vec<Gear>,
    /// GCON statements.
    pub gcons: Vec<Gcon>,
    /// MOTION statements.
    pub motions: Vec<Motion>,
    /// BUSHING statements.
    pub bushings: Vec<Bushing>,
    /// FIELD and BEAM statements, and all other forces defined by a law of the grammar.
    pub pair_forces: Vec<PairForce>,
    /// SPRINGDAMPER statements.
    pub springdampers: Vec<SpringDamper>,
    /// SFORCE statements.
    pub sforces: Vec<Sforce>,
    /// GFORCE, VFORCE and VTORQUE statements.
    pub vector_forces: Vec<VectorForce>,
    /// NFORCE statements.
    pub nforces: Vec<Nforce>,
    /// VARIABLE statements.
    pub variables: Vec<Variable>,
    /// DIFF statements.
    pub diffs: Vec<Diff>,
    /// LSE and TFSISO statements.
    pub linear_states: Vec<LinearStates>,
    /// ARRAY statements.
    pub arrays: Vec<ArrayData>,
    /// SPLINE statements.
    pub splines: Vec<Spline>,
    /// STRING statements.
    pub strings: Vec<StringData>,
    /// SENSOR statements.
    pub sensors: Vec<Sensor>,
    /// PINPUT, POUTPUT and PSTATE statements.
    pub plant_ports: Vec<PlantPort>,
    /// FRICTION statements.
    pub frictions: Vec<Friction>,
    /// REQUEST statements.
    pub requests: Vec<Request>,
    /// Settings of EQUILIBRIUM.
    pub equilibrium: EquilibriumSettings,
    /// Settings of INTEGRATOR.
    pub integrator: IntegratorSettings,
    /// Settings of KINEMATICS.
    pub kinematics: KinematicsSettings,
    /// Arguments of IC that the dataset states. They have no effect, because initial conditions are always satisfied to round-off.
    pub initial_conditions: Vec<&'static str>,
    /// Settings of OUTPUT.
    pub output: OutputSettings,
    /// Settings of RESULTS.
    pub results: ResultsSettings,
    /// Statements that the built-in solver does not solve.
    pub unsolved: Vec<Unsolved>,
}

impl Model {
    /// Returns the index of the marker with this id.
    pub fn marker(&self, id: u32) -> Option<MarkerIx> {
        self.markers
            .iter()
            .position(|marker| marker.header.id == id)
            .map(MarkerIx)
    }

    /// Returns the pose of a marker in ground in the design position. Returns `None` for floating markers and for markers on bodies that
    /// only real ADAMS places.
    pub fn marker_pose(&self, marker: MarkerIx) -> Option<Pose> {
        let marker = &self.markers[marker.0];
        let part = &self.parts[marker.part.0];
        if marker.floating || part.kind == PartKind::External {
            return None;
        }
        Some(part.pose.compose(&Pose {
            p: marker.qp,
            R: marker.R,
        }))
    }

    /// Returns whether the frame of a marker is given relative to one of the markers `others` (RM), directly or through other markers. The
    /// marker then moves with that marker.
    pub fn moves_with(&self, marker: MarkerIx, others: &[MarkerIx]) -> bool {
        let parent = |marker: &MarkerIx| {
            let relative = self.markers[marker.0].relative.as_ref();
            relative.map(|relative| relative.rm)
        };
        // The chain is limited, because markers defined in each other's frames would form an endless chain.
        let chain = std::iter::successors(parent(&marker), parent);
        chain
            .take(self.markers.len())
            .any(|rm| others.contains(&rm))
    }

    /// Returns the number of elements of an array. The size of a state or output array follows from the linear state equations that use it
    /// (state_array).
    pub fn array_size(&self, array: &ArrayData) -> usize {
        let id = array.header.id;
        let mut equations = self.linear_states.iter();
        match &array.kind {
            ArrayKind::Numbers(numbers) => numbers.len(),
            ArrayKind::Variables(variables) => variables.len(),
            ArrayKind::States(size) => equations
                .find(|of| of.x == id)
                .map_or(*size, |of| of.a.len()),
            ArrayKind::Outputs(size) => equations
                .find(|of| of.y == Some(id))
                .map_or(*size, |of| of.c.len().max(of.d.len())),
        }
    }

    /// Returns the index of the ground part.
    pub fn ground(&self) -> Option<PartIx> {
        self.parts
            .iter()
            .position(|part| part.kind == PartKind::Ground)
            .map(PartIx)
    }
}
