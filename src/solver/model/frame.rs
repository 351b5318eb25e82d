use super::Header;
use crate::mechanics::{Mat3, Pose, Vec3};

/// Index into [`Model::parts`](super::Model::parts).
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct PartIx(pub usize);

/// Index into [`Model::markers`](super::Model::markers).
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct MarkerIx(pub usize);

/// What kind of body.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum PartKind {
    /// At rest; its frame is the global frame.
    Ground,
    /// Six freedoms.
    Rigid,
    /// POINT_MASS: three freedoms, always parallel to ground.
    PointMass,
    /// FLEX_BODY, FE_PART: only real ADAMS solves these.
    External,
}

/// PART or POINT_MASS.
#[derive(Clone, PartialEq, Debug)]
pub struct Part {
    /// Id, name, origin.
    pub header: Header,
    /// What kind of body.
    pub kind: PartKind,
    /// MASS.
    pub mass: f64,
    /// CM marker.
    pub cm: Option<MarkerIx>,
    /// IP: xx, yy, zz, xy, xz, yz with products as positive integrals.
    pub ip: [f64; 6],
    /// Initial pose of the part frame (BCS) in ground: QG and REULER or ZG, XG.
    pub pose: Pose,
    /// EXACT: x, y, z, psi, theta, phi that assembly should keep.
    pub exact: [bool; 6],
    /// How it begins to move.
    pub start: InitialVelocity,
}

/// VX to WZ of a PART: what is not given adapts to the constraints.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct InitialVelocity {
    /// VX, VY, VZ of the centre of mass.
    pub linear: [Option<f64>; 3],
    /// VM: the marker whose axes they are along; ground if absent.
    pub linear_axes: Option<MarkerIx>,
    /// WX, WY, WZ, radians per time.
    pub angular: [Option<f64>; 3],
    /// WM: the marker whose axes they are along; the CM marker if absent.
    pub angular_axes: Option<MarkerIx>,
}

/// How a marker's orientation was given.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Orientation {
    /// REULER=psi,theta,phi in radians (zeros if nothing is given).
    Reuler([f64; 3]),
    /// ZP and XP points, in the part frame.
    Points,
}

/// What a MARKER with RM states: a frame in the axes of another marker.
#[derive(Clone, PartialEq, Debug)]
pub struct Relative {
    /// RM: the marker in whose frame the numbers are.
    pub rm: MarkerIx,
    /// QP, in the frame of RM.
    pub qp: Vec3,
    /// How the orientation was given, in the frame of RM.
    pub orientation: Orientation,
    /// Rotation in the frame of RM.
    pub R: Mat3,
}

/// MARKER: a frame on a part.
#[derive(Clone, PartialEq, Debug)]
pub struct Marker {
    /// Id, name, origin.
    pub header: Header,
    /// The part it is on.
    pub part: PartIx,
    /// QP: origin in the part frame.
    pub qp: Vec3,
    /// How the orientation was given.
    pub orientation: Orientation,
    /// Rotation of the marker in the part frame.
    pub R: Mat3,
    /// FLOATING: has no place of its own.
    pub floating: bool,
    /// What it states, if that is in the frame of another marker.
    pub relative: Option<Relative>,
}

impl Marker {
    /// A displacement in axes of its part as a change of QP, which is in axes of RM if it has one.
    pub fn as_written(&self, displacement: &Vec3) -> Vec3 {
        match &self.relative {
            Some(relative) => relative.R * (self.R.transpose() * displacement),
            None => *displacement,
        }
    }
}
