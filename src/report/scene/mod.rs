//! Three-dimensional view of a mechanism: its geometry as data, and the poses of its parts in every step or load case.
//!
//! This module uses the model and poses; it is independent of solvers and fits. The script `viewer.js` draws the scene in a browser.

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

/// Frame as seven numbers: origin, then the quaternion w, x, y, z.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
#[serde(transparent)]
pub struct Placed(pub [f64; 7]);

/// Kind of a drawn object.
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

/// Marker of an object.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct End {
    /// Index into [`Scene::parts`].
    pub part: usize,
    /// Frame of the marker in the part's frame.
    pub at: Placed,
}

/// Joint, force element or force.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Object {
    /// View name.
    pub name: String,
    /// Address, such as `BUSHING/1`.
    pub address: String,
    /// Kind of object, which determines its drawing.
    pub kind: Kind,
    /// Type in the words of the statement, for example `revolute`.
    pub form: String,
    /// I marker.
    pub i: End,
    /// J marker, if the object has one.
    pub j: Option<End>,
    /// Ids of the object's markers.
    #[serde(skip)]
    pub markers: Vec<u32>,
}

/// Part: its corners in its own frame, with faces, edges and lines between them.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Body {
    /// View name.
    pub name: String,
    /// Address, such as `PART/4`.
    pub address: String,
    /// True for ground, which never moves.
    pub ground: bool,
    /// Pose in the deck.
    pub design: Placed,
    /// Corners, in the part's frame.
    pub points: Vec<[f64; 3]>,
    /// Indices of the corners of each face, in order around it.
    pub faces: Vec<Vec<usize>>,
    /// Edges between corners.
    pub edges: Vec<[usize; 2]>,
    /// Thin lines between corners, from shapes of GRAPHICS statements.
    pub lines: Vec<Vec<usize>>,
}

/// Measurement mark on a part.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Mark {
    /// Label of the mark.
    pub label: String,
    /// Index into [`Scene::parts`].
    pub part: usize,
    /// Position in the part's frame.
    pub p: [f64; 3],
}

/// Origin of a set of positions.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Deck or simulation run.
    Model,
    /// Measurement.
    Measured,
    /// Model before a fit.
    Initial,
    /// Model with identified numbers.
    Fitted,
    /// Model extended by a finding.
    Extended,
}

impl Role {
    /// Returns its colour index in the style sheet, the same in every picture of a page; `viewer.js` has the same table.
    pub(crate) const fn colour(self) -> usize {
        match self {
            Self::Model | Self::Fitted => 1,
            Self::Measured => 4,
            Self::Extended => 3,
            Self::Initial => 7,
        }
    }
}

/// Set of positions shown together in one colour.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Set {
    /// Name in the legend.
    pub name: String,
    /// Origin of the positions.
    pub role: Role,
}

/// Load drawn as an arrow at the I marker of an object.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Arrow {
    /// Index into [`Scene::objects`].
    pub object: usize,
    /// Force in ground axes, in the scene's unit of force.
    pub force: [f64; 3],
}

/// One step of a run, or one load case.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Frame {
    /// Label of the frame.
    pub label: String,
    /// Description of its loads or time.
    pub note: String,
    /// Poses by set and part; `None` where the pose is unknown.
    pub poses: Vec<Vec<Option<Placed>>>,
    /// Measured position of each mark, in ground; `None` where it was not read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<Option<[f64; 3]>>,
    /// Loads drawn as arrows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub arrows: Vec<Arrow>,
}

/// Object or part named by a finding.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Highlight {
    /// Address, such as `BUSHING/1` or `PART/4`.
    pub address: String,
    /// Text shown beside it.
    pub label: String,
}

/// Three-dimensional view of a mechanism.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Scene {
    /// Title of the view.
    pub title: String,
    /// Unit of length.
    pub length: String,
    /// Unit of force.
    pub force: String,
    /// Upward direction, opposite to gravity; +z without gravity.
    pub up: [f64; 3],
    /// Axis of travel: the level ground axis along which the front view looks.
    pub along: [f64; 3],
    /// Parts in the order of the model.
    pub parts: Vec<Body>,
    /// Joints, force elements and forces.
    pub objects: Vec<Object>,
    /// Measurement marks.
    pub marks: Vec<Mark>,
    /// Sets of positions in the frames; the last set is drawn in full.
    pub sets: Vec<Set>,
    /// Word for one frame: `step` or `case`.
    pub per: String,
    /// Steps or load cases. If empty, the parts are drawn in their design position.
    pub frames: Vec<Frame>,
    /// Objects and parts named by findings.
    pub highlight: Vec<Highlight>,
    /// Remarks for the reader.
    pub notes: Vec<String>,
}

impl Placed {
    /// Rounds a pose to the precision required for a picture whose displacements may be magnified a thousand times.
    pub(crate) fn new(pose: &Pose) -> Self {
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(pose.R);
        let q = nalgebra::UnitQuaternion::from_rotation_matrix(&rotation);
        let p = pose.p;
        let seven = [p.x, p.y, p.z, q.w, q.i, q.j, q.k];
        Self(seven.map(short))
    }
}

/// Rounds to nine significant digits. A value that is not finite becomes zero, because JSON cannot represent it.
fn short(value: f64) -> f64 {
    if !value.is_finite() {
        return 0.0;
    }
    format!("{value:.8e}").parse().unwrap_or(value)
}

/// Converts a point to three rounded numbers.
pub(super) fn point(p: &Vec3) -> [f64; 3] {
    [p.x, p.y, p.z].map(short)
}
