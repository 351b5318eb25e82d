//! A mechanism as a picture in three dimensions: its geometry as data, and where its parts are in every step or load case.
//!
//! Knows the model and poses; neither solvers nor fits. The client that draws it in a browser is `viewer.js`.

mod build;
mod embed;
mod hull;
mod motion;
mod shapes;

use serde::Serialize;

use admire_solver::mechanics::{Pose, Vec3};

pub(super) use build::along;
pub(crate) use hull::Hull;
pub use motion::{Motion, bodies, motion};

pub(super) use embed::{CLIENT, CLIENT_STYLE};

/// A frame as seven numbers: origin, then the quaternion w, x, y, z.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
#[serde(transparent)]
pub struct Placed(pub [f64; 7]);

/// What an object of the scene is drawn as.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// JOINT.
    Joint,
    /// JPRIM.
    Primitive,
    /// MOTION.
    Motion,
    /// BUSHING.
    Bushing,
    /// FIELD or NFORCE.
    Field,
    /// BEAM.
    Beam,
    /// SPRINGDAMPER.
    Spring,
    /// SFORCE, GFORCE, VFORCE, VTORQUE.
    Force,
}

/// A marker of an object: the index of its part, and its frame in the part's frame.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct End {
    /// Index into [`Scene::parts`].
    pub part: usize,
    /// In the part's frame.
    pub at: Placed,
}

/// A joint, a force element or a force.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Object {
    /// Its view name.
    pub name: String,
    /// `BUSHING/1`.
    pub address: String,
    /// What it is drawn as.
    pub kind: Kind,
    /// Its type in the statement's words, for example `revolute`.
    pub form: String,
    /// The I marker.
    pub i: End,
    /// The J marker, if the object has one.
    pub j: Option<End>,
    /// Ids of its markers.
    #[serde(skip)]
    pub markers: Vec<u32>,
}

/// A part: its corners in its own frame, and what joins them.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Body {
    /// Its view name.
    pub name: String,
    /// `PART/4`.
    pub address: String,
    /// True for ground, which never moves.
    pub ground: bool,
    /// Where the deck puts it.
    pub design: Placed,
    /// Corners, in the part's frame.
    pub points: Vec<[f64; 3]>,
    /// Corners of faces, in order around each.
    pub faces: Vec<Vec<usize>>,
    /// Edges between corners.
    pub edges: Vec<[usize; 2]>,
    /// Thin lines between corners: shapes of GRAPHICS statements.
    pub lines: Vec<Vec<usize>>,
}

/// A mark of a measurement on a part.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Mark {
    /// Its label.
    pub label: String,
    /// Index into [`Scene::parts`].
    pub part: usize,
    /// In the part's frame.
    pub p: [f64; 3],
}

/// Whose positions these are.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// The deck or a run.
    Model,
    /// As the rig read them.
    Measured,
    /// The model before a fit.
    Initial,
    /// The model with identified numbers.
    Fitted,
    /// The model with a finding added.
    Extended,
}

impl Role {
    /// Which of the colours of the style sheet it has in every picture of a page; `viewer.js` has the same.
    pub(crate) const fn colour(self) -> usize {
        match self {
            Self::Model | Self::Fitted => 1,
            Self::Measured => 4,
            Self::Extended => 3,
            Self::Initial => 7,
        }
    }
}

/// Positions that are shown together in one colour.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Set {
    /// Name in the legend.
    pub name: String,
    /// Whose positions.
    pub role: Role,
}

/// A load drawn as an arrow at the I marker of an object.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Arrow {
    /// Index into [`Scene::objects`].
    pub object: usize,
    /// In ground axes, in the scene's unit of force.
    pub force: [f64; 3],
}

/// One step of a run or one load case.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Frame {
    /// Its label.
    pub label: String,
    /// What acts in it.
    pub note: String,
    /// Per set and part; `None` where the part's place is not known.
    pub poses: Vec<Vec<Option<Placed>>>,
    /// Per mark, as measured, in ground.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<Option<[f64; 3]>>,
    /// Loads.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub arrows: Vec<Arrow>,
}

/// An object or part that a finding names.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Highlight {
    /// Its address: `BUSHING/1`, `PART/4`.
    pub address: String,
    /// What to write beside it.
    pub label: String,
}

/// The picture.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Scene {
    /// What is shown.
    pub title: String,
    /// Unit of length.
    pub length: String,
    /// Unit of force.
    pub force: String,
    /// Against gravity; +z without gravity.
    pub up: [f64; 3],
    /// The axis of travel, level: that of ground along which the front view looks.
    pub along: [f64; 3],
    /// Parts, in the order of the model.
    pub parts: Vec<Body>,
    /// Joints, force elements and forces.
    pub objects: Vec<Object>,
    /// Marks.
    pub marks: Vec<Mark>,
    /// Whose positions the frames hold; the last set is the one drawn in full.
    pub sets: Vec<Set>,
    /// Word for one frame: `step` or `case`.
    pub per: String,
    /// Steps or cases. Without any the parts stand where the deck puts them.
    pub frames: Vec<Frame>,
    /// What findings name.
    pub highlight: Vec<Highlight>,
    /// What a person should know about the picture.
    pub notes: Vec<String>,
}

impl Placed {
    /// A pose with so many decimals as a picture needs whose displacements may be enlarged a thousand times.
    pub(crate) fn new(pose: &Pose) -> Self {
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(pose.R);
        let q = nalgebra::UnitQuaternion::from_rotation_matrix(&rotation);
        let p = pose.p;
        let seven = [p.x, p.y, p.z, q.w, q.i, q.j, q.k];
        Self(seven.map(short))
    }
}

/// Nine significant digits; what is not finite becomes zero, which JSON can hold.
fn short(value: f64) -> f64 {
    if !value.is_finite() {
        return 0.0;
    }
    format!("{value:.8e}").parse().unwrap_or(value)
}

/// A point as three numbers.
pub(super) fn point(p: &Vec3) -> [f64; 3] {
    [p.x, p.y, p.z].map(short)
}
