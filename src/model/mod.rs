//! The resolved model: typed, named objects with numbers in the dataset's units and angles in radians.
//!
//! Knows nothing about how it was written. Each object keeps its `origin`, the statement it came from; the bytes of a number
//! are found through its [`Address`](crate::syntax) in the dataset.

mod constraint;
mod data;
mod force;
mod frame;
pub mod lint;
mod lower;
mod object;
mod settings;
pub mod summary;
mod user_force;

pub use constraint::{
    Coupler, CouplerKind, Gcon, Gear, Joint, JointKind, Motion, MotionAxis, MotionOrder, Primitive,
    PrimitiveKind,
};
pub use data::{
    ArrayData, ArrayKind, Diff, LinearStates, PlantPort, Request, RequestKind, Sensor,
    SensorCompare, Spline, StringData, Variable,
};
pub use force::{
    Beam, BeamFormulation, Bushing, Field, Nforce, Sforce, SforceKind, SpringDamper, SpringKind,
    VectorForce, VectorForceKind,
};
pub use frame::{Marker, MarkerIx, Orientation, Part, PartIx, PartKind};
pub use lower::lower;
pub use settings::{EquilibriumSettings, OutputSettings, ResultsSettings, StaticMethod};
pub use user_force::{Replacement, replace_user_forces};

use crate::mechanics::Vec3;
use crate::units::Units;

/// What every object has.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Header {
    /// The id of its statement.
    pub id: u32,
    /// The view name, or kind and id (`PART_2`) where the file gives none.
    pub name: String,
    /// Index of its statement in the dataset it came from.
    pub origin: usize,
    /// False after DEACTIVATE.
    pub active: bool,
}

/// A FUNCTION of the model: its text as written (continuation removed) and the parsed expression.
#[derive(Clone, PartialEq, Debug)]
pub enum Function {
    /// An expression, the one the dataset holds.
    Expression(std::sync::Arc<crate::syntax::Expression>),
    /// `USER(...)`: a subroutine only real ADAMS can run. The text as written.
    User(String),
}

/// A statement the built-in solver cannot solve, and why.
#[derive(Clone, PartialEq, Debug)]
pub struct Unsolved {
    /// What every object has.
    pub header: Header,
    /// The statement's keyword in capitals.
    pub kind: &'static str,
    /// Why only real ADAMS can solve it, and what leaving it out does to the answer.
    pub why: String,
}

/// One dataset, resolved.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Model {
    /// The first line of the dataset.
    pub title: String,
    /// Units and the consistency factor.
    pub units: Units,
    /// Acceleration of gravity in ground axes.
    pub gravity: Vec3,
    /// Parts and point masses in order of appearance. Exactly one is ground.
    pub parts: Vec<Part>,
    /// Markers in order of appearance.
    pub markers: Vec<Marker>,
    /// JOINTs.
    pub joints: Vec<Joint>,
    /// JPRIMs.
    pub primitives: Vec<Primitive>,
    /// COUPLERs.
    pub couplers: Vec<Coupler>,
    /// GEARs.
    pub gears: Vec<Gear>,
    /// GCONs.
    pub gcons: Vec<Gcon>,
    /// MOTIONs.
    pub motions: Vec<Motion>,
    /// BUSHINGs.
    pub bushings: Vec<Bushing>,
    /// FIELDs.
    pub fields: Vec<Field>,
    /// BEAMs.
    pub beams: Vec<Beam>,
    /// SPRINGDAMPERs.
    pub springdampers: Vec<SpringDamper>,
    /// SFORCEs.
    pub sforces: Vec<Sforce>,
    /// GFORCEs, VFORCEs and VTORQUEs.
    pub vector_forces: Vec<VectorForce>,
    /// NFORCEs.
    pub nforces: Vec<Nforce>,
    /// VARIABLEs.
    pub variables: Vec<Variable>,
    /// DIFFs.
    pub diffs: Vec<Diff>,
    /// LSE, GSE and TFSISO.
    pub linear_states: Vec<LinearStates>,
    /// ARRAYs.
    pub arrays: Vec<ArrayData>,
    /// SPLINEs.
    pub splines: Vec<Spline>,
    /// STRINGs.
    pub strings: Vec<StringData>,
    /// SENSORs.
    pub sensors: Vec<Sensor>,
    /// PINPUTs and POUTPUTs.
    pub plant_ports: Vec<PlantPort>,
    /// FRICTIONs: they take no part in statics.
    pub frictions: Vec<Header>,
    /// REQUESTs.
    pub requests: Vec<Request>,
    /// EQUILIBRIUM.
    pub equilibrium: EquilibriumSettings,
    /// OUTPUT.
    pub output: OutputSettings,
    /// RESULTS.
    pub results: ResultsSettings,
    /// What the built-in solver leaves out.
    pub unsolved: Vec<Unsolved>,
}

impl Model {
    /// The marker with this id.
    pub fn marker(&self, id: u32) -> Option<MarkerIx> {
        self.markers
            .iter()
            .position(|marker| marker.header.id == id)
            .map(MarkerIx)
    }

    /// The ground part.
    pub fn ground(&self) -> Option<PartIx> {
        self.parts
            .iter()
            .position(|part| part.kind == PartKind::Ground)
            .map(PartIx)
    }
}
