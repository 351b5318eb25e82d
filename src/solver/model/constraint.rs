use super::{Function, Header, MarkerIx};

/// Type of a JOINT.
#[derive(Clone, Copy, PartialEq, Debug)]
#[allow(missing_docs)] // The names are those of the manual.
pub enum JointKind {
    Spherical,
    Revolute,
    Translational,
    Cylindrical,
    Planar,
    Fixed,
    Hooke,
    Universal,
    Convel,
    /// Screw joint with its PITCH, the translation per turn.
    Screw {
        pitch: f64,
    },
    /// Rack-and-pinion joint with its pitch diameter PD.
    RackPin {
        pitch_diameter: f64,
    },
}

impl JointKind {
    /// Returns the type keyword in the statement.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Spherical => "SPHERICAL",
            Self::Revolute => "REVOLUTE",
            Self::Translational => "TRANSLATIONAL",
            Self::Cylindrical => "CYLINDRICAL",
            Self::Planar => "PLANAR",
            Self::Fixed => "FIXED",
            Self::Hooke => "HOOKE",
            Self::Universal => "UNIVERSAL",
            Self::Convel => "CONVEL",
            Self::Screw { .. } => "SCREW",
            Self::RackPin { .. } => "RACKPIN",
        }
    }

    /// Returns the parameter PITCH or PD of a SCREW or RACKPIN joint. Other joints have no parameter.
    pub(crate) const fn number(self) -> Option<f64> {
        match self {
            Self::Screw { pitch } => Some(pitch),
            Self::RackPin { pitch_diameter } => Some(pitch_diameter),
            _ => None,
        }
    }
}

/// JOINT statement.
#[derive(Clone, PartialEq, Debug)]
pub struct Joint {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Type of the joint.
    pub kind: JointKind,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// Initial displacement along zj and, if given, its initial rate (IC or ICTRAN).
    pub initial_translation: Option<(f64, Option<f64>)>,
    /// Initial rotation about zj in radians and, if given, its initial rate (IC or ICROT).
    pub initial_rotation: Option<(f64, Option<f64>)>,
}

/// Type of a JPRIM.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are those of the manual.
pub enum PrimitiveKind {
    AtPoint,
    Inline,
    Inplane,
    Orientation,
    ParallelAxes,
    Perpendicular,
}

impl PrimitiveKind {
    /// Returns the type keyword in the statement.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::AtPoint => "ATPOINT",
            Self::Inline => "INLINE",
            Self::Inplane => "INPLANE",
            Self::Orientation => "ORIENTATION",
            Self::ParallelAxes => "PARALLEL_AXES",
            Self::Perpendicular => "PERPENDICULAR",
        }
    }
}

/// JPRIM statement.
#[derive(Clone, PartialEq, Debug)]
pub struct Primitive {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Type of the joint primitive.
    pub kind: PrimitiveKind,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
}

/// Joint displacement that enters the sum of a COUPLER.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum CouplerKind {
    /// Translation along zj.
    Translation,
    /// Rotation about zj.
    Rotation,
}

/// COUPLER: constrains the sum of joint displacements, each multiplied by its scale, to zero.
#[derive(Clone, PartialEq, Debug)]
pub struct Coupler {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Terms of the sum: the joint as an index into `Model::joints`, its displacement, and the scale.
    pub terms: Vec<(usize, CouplerKind, f64)>,
}

/// GEAR statement.
#[derive(Clone, PartialEq, Debug)]
pub struct Gear {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// The two joints, as indices into `Model::joints`.
    pub joints: [usize; 2],
    /// Common-velocity marker.
    pub cv: MarkerIx,
}

/// GCON: constrains a function to zero.
#[derive(Clone, PartialEq, Debug)]
pub struct Gcon {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// I marker, at which the reaction is reported.
    pub i: Option<MarkerIx>,
    /// Constrained function.
    pub function: Function,
}

/// Displacement that a MOTION prescribes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum MotionAxis {
    /// Displacement component along an axis of J: 0, 1, 2 for X, Y, Z.
    Translation(usize),
    /// Rotation about zj, used by motions of a joint.
    RotationZ,
    /// Body-fixed 1-2-3 angle: 0, 1, 2 for B1, B2, B3.
    Body123(usize),
}

impl MotionAxis {
    /// Returns the keyword of this displacement in the MOTION statement.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Translation(axis) => ["X", "Y", "Z"][axis],
            Self::RotationZ => "ROTATIONAL",
            Self::Body123(axis) => ["B1", "B2", "B3"][axis],
        }
    }
}

/// Order of the time derivative that a MOTION prescribes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are those of the manual.
pub enum MotionOrder {
    Displacement,
    Velocity,
    Acceleration,
}

/// MOTION statement. A named joint is resolved to its I and J markers.
#[derive(Clone, PartialEq, Debug)]
pub struct Motion {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Driven joint (index into `Model::joints`), if the statement names a joint.
    pub joint: Option<usize>,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// Prescribed displacement.
    pub axis: MotionAxis,
    /// Order of the prescribed time derivative: displacement, velocity or acceleration.
    pub order: MotionOrder,
    /// Initial displacement, ICDISP.
    pub initial_displacement: Option<f64>,
    /// Initial velocity, ICVEL.
    pub initial_velocity: Option<f64>,
    /// FUNCTION: the prescribed value as a function of time or of the state.
    pub function: Function,
}
