//! Three-dimensional view of a mechanism: its geometry as data, and the poses of its parts in every simulation step or load case.
//!
//! This module uses the model and poses; it is independent of solvers and fits. The script `viewer.js` draws the scene in a browser.

mod build;
mod embed;
mod hull;
mod motion;
mod shapes;
mod wheel;

use serde::Serialize;

use admire_solver::mechanics::{Pose, Vec3};

pub(super) use build::along;
pub(crate) use hull::Hull;
pub use motion::{Motion, bodies, motion};
pub use wheel::Wheel;
pub(super) use wheel::on_marker;

pub(super) use embed::{CLIENT, CLIENT_STYLE};

/// Pose as seven numbers: the origin x, y, z, then the quaternion w, x, y, z.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
#[serde(transparent)]
pub struct Placed(pub [f64; 7]);

/// Kind of a drawn object, by its ADAMS statement.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// JOINT statement.
    Joint,
    /// JPRIM statement.
    Primitive,
    /// MOTION statement.
    Motion,
    /// BUSHING statement.
    Bushing,
    /// FIELD or NFORCE statement.
    Field,
    /// BEAM statement.
    Beam,
    /// SPRINGDAMPER statement.
    Spring,
    /// SFORCE, GFORCE, VFORCE or VTORQUE statement.
    Force,
}

/// Marker at which an object is attached to a part.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct End {
    /// Index of the part in [`Scene::parts`].
    pub part: usize,
    /// Pose of the marker in the frame of the part.
    pub at: Placed,
}

/// Drawn object: a joint, a force element or an applied force.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Object {
    /// ADAMS View name of the object.
    pub name: String,
    /// Address of the object, such as `BUSHING/1`.
    pub address: String,
    /// Kind of object, which determines its drawing.
    pub kind: Kind,
    /// Type as named in the statement, for example `revolute`.
    pub form: String,
    /// I marker of the object.
    pub i: End,
    /// J marker of the object, if it has one.
    pub j: Option<End>,
    /// Ids of the object's markers.
    #[serde(skip)]
    pub markers: Vec<u32>,
}

/// Drawn part: its corners in its own frame, with faces, edges and lines between them.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Body {
    /// ADAMS View name of the part.
    pub name: String,
    /// Address of the part, such as `PART/4`.
    pub address: String,
    /// True for ground, which never moves.
    pub ground: bool,
    /// Pose of the part in the design position of the deck.
    pub design: Placed,
    /// Corners and points of lines, in the frame of the part.
    pub points: Vec<[f64; 3]>,
    /// Faces, each as the indices of its corners in order around the face.
    pub faces: Vec<Vec<usize>>,
    /// Edges, each as the indices of its two corners.
    pub edges: Vec<[usize; 2]>,
    /// Thin lines from shapes of GRAPHICS statements, each as the indices of its points.
    pub lines: Vec<Vec<usize>>,
}

/// Mark: a measured point on a part.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Mark {
    /// Label of the mark.
    pub label: String,
    /// Index of the part in [`Scene::parts`].
    pub part: usize,
    /// Position of the mark in the frame of the part.
    pub p: [f64; 3],
}

/// Role of a curve or of a set of positions, which determines its name and its colour.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Positions from the deck or from a simulation run.
    Model,
    /// Measured positions.
    Measured,
    /// The model as given: before a fit.
    #[serde(rename = "model as given")]
    Given,
    /// The model with identified parameters.
    Identified,
    /// The model extended by the findings of a diagnosis.
    Extended,
}

impl Role {
    /// Returns the name of the role in every legend.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Model => "model",
            Self::Measured => "measured",
            Self::Given => "model as given",
            Self::Identified => "identified",
            Self::Extended => "extended",
        }
    }

    /// Returns the class of the role in the style sheet, which gives it one colour in every picture; `viewer.js` contains the same table.
    pub(crate) const fn class(self) -> &'static str {
        match self {
            Self::Model => "s1",
            Self::Measured => "s-measured",
            Self::Given => "s-given",
            Self::Identified => "s-identified",
            Self::Extended => "s-extended",
        }
    }
}

/// Load drawn as an arrow at the I marker of an object.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Arrow {
    /// Index of the object in [`Scene::objects`].
    pub object: usize,
    /// Force in ground axes, in the scene's unit of force.
    pub force: [f64; 3],
}

/// Frame of the view: one simulation step, or one load case.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Frame {
    /// Label of the frame.
    pub label: String,
    /// Description of the loads or of the time of the frame.
    pub note: String,
    /// Poses by set, then by part; `None` where the pose is unknown.
    pub poses: Vec<Vec<Option<Placed>>>,
    /// Measured position of each mark in ground axes; `None` for a mark that was not read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<Option<[f64; 3]>>,
    /// Loads of the frame, drawn as arrows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub arrows: Vec<Arrow>,
}

/// Highlight of an object or part that a finding names.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Highlight {
    /// Address of the object or part, such as `BUSHING/1` or `PART/4`.
    pub address: String,
    /// Text shown beside the object or part.
    pub label: String,
}

/// Three-dimensional view of a mechanism.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Scene {
    /// Title of the view.
    pub title: String,
    /// Name of the length unit.
    pub length: String,
    /// Name of the force unit.
    pub force: String,
    /// Upward direction in ground axes: opposite to gravity, or +z without gravity.
    pub up: [f64; 3],
    /// Direction of travel: the horizontal ground axis along which the front view looks.
    pub along: [f64; 3],
    /// Parts in the order of the model.
    pub parts: Vec<Body>,
    /// Drawn joints, force elements and applied forces.
    pub objects: Vec<Object>,
    /// Wheels of the vehicle.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub wheels: Vec<Wheel>,
    /// Marks (measured points) of the parts.
    pub marks: Vec<Mark>,
    /// Roles of the sets of positions shown in each frame; the last set is drawn in full.
    pub sets: Vec<Role>,
    /// Word for one frame in the controls: `step` or `case`.
    pub per: String,
    /// Frames of the view. If there are none, the parts are drawn in their design position.
    pub frames: Vec<Frame>,
    /// Highlights of objects and parts that findings name.
    pub highlight: Vec<Highlight>,
    /// Remarks shown to the reader.
    pub notes: Vec<String>,
}

impl Placed {
    /// Converts a pose to rounded numbers. They are precise enough for a picture whose displacements are magnified a thousand times.
    pub(crate) fn new(pose: &Pose) -> Self {
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(pose.R);
        let q = nalgebra::UnitQuaternion::from_rotation_matrix(&rotation);
        let p = pose.p;
        let seven = [p.x, p.y, p.z, q.w, q.i, q.j, q.k];
        Self(seven.map(short))
    }
}

/// Rounds a value to nine significant digits. A value that is not finite becomes zero, because JSON cannot represent it.
fn short(value: f64) -> f64 {
    if !value.is_finite() {
        return 0.0;
    }
    format!("{value:.8e}").parse().unwrap_or(value)
}

/// Converts a point to three rounded coordinates.
pub(super) fn point(p: &Vec3) -> [f64; 3] {
    [p.x, p.y, p.z].map(short)
}
