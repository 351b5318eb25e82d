use super::Header;
use crate::mechanics::{Mat3, Pose, Vec3};

/// Index into [`Model::parts`](super::Model::parts).
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct PartIx(pub usize);

/// Index into [`Model::markers`](super::Model::markers).
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct MarkerIx(pub usize);

/// Kind of body.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum PartKind {
    /// Ground: at rest; its frame is the global frame.
    Ground,
    /// Rigid body with six degrees of freedom.
    Rigid,
    /// POINT_MASS: three degrees of freedom; its axes stay parallel to ground.
    PointMass,
    /// FLEX_BODY or FE_PART, which only real ADAMS solves.
    External,
}

/// Body of the model: a PART, a POINT_MASS, or a flexible body that only real ADAMS solves.
#[derive(Clone, PartialEq, Debug)]
pub struct Part {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Kind of body.
    pub kind: PartKind,
    /// Mass, MASS.
    pub mass: f64,
    /// CM: marker at the centre of mass.
    pub cm: Option<MarkerIx>,
    /// Moments of inertia IP: xx, yy, zz, xy, xz, yz, with the products of inertia as positive integrals.
    pub ip: [f64; 6],
    /// Initial pose of the part frame (BCS) in ground: QG and REULER or ZG, XG.
    pub pose: Pose,
    /// EXACT: whether assembly should keep each of x, y, z, psi, theta, phi.
    pub exact: [bool; 6],
    /// Initial velocity.
    pub start: InitialVelocity,
}

/// Initial velocity of a PART, VX to WZ. Components that are not given are chosen so that the constraints are satisfied.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct InitialVelocity {
    /// VX, VY, VZ: components of the velocity of the centre of mass.
    pub linear: [Option<f64>; 3],
    /// VM: marker that gives the axes of the linear velocity; ground axes if absent.
    pub linear_axes: Option<MarkerIx>,
    /// WX, WY, WZ: components of the angular velocity, radians per time.
    pub angular: [Option<f64>; 3],
    /// WM: marker that gives the axes of the angular velocity; CM marker if absent.
    pub angular_axes: Option<MarkerIx>,
}

/// Form in which the orientation of a marker was given.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Orientation {
    /// REULER=psi,theta,phi in radians (zeros if nothing is given).
    Reuler([f64; 3]),
    /// Points ZP and XP that define the axes. Also used for any other form without Euler angles.
    Points,
}

/// Frame of a MARKER with RM, as given in the frame of marker RM.
#[derive(Clone, PartialEq, Debug)]
pub struct Relative {
    /// RM: marker in whose frame the values are given.
    pub rm: MarkerIx,
    /// Origin QP in the frame of RM.
    pub qp: Vec3,
    /// Form in which the orientation was given.
    pub orientation: Orientation,
    /// Rotation of the marker in the frame of RM.
    pub R: Mat3,
}

/// MARKER: a frame fixed on a part.
#[derive(Clone, PartialEq, Debug)]
pub struct Marker {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Part that carries the marker.
    pub part: PartIx,
    /// Origin in the part frame (QP).
    pub qp: Vec3,
    /// Form in which the orientation was given.
    pub orientation: Orientation,
    /// Rotation of the marker in the part frame.
    pub R: Mat3,
    /// FLOATING: the marker has no fixed position.
    pub floating: bool,
    /// Frame as given in the statement, if it is given relative to another marker (RM).
    pub relative: Option<Relative>,
}

impl Marker {
    /// Converts a displacement in part axes to a change of QP as written in the statement. For a marker with RM, QP is given in the frame
    /// of RM.
    pub fn as_written(&self, displacement: &Vec3) -> Vec3 {
        match &self.relative {
            Some(relative) => relative.R * (self.R.transpose() * displacement),
            None => *displacement,
        }
    }
}
