use super::{Function, Header, MarkerIx};

/// The type of a JOINT.
#[derive(Clone, Copy, PartialEq, Debug)]
#[allow(missing_docs)] // The names are the manual's.
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
    /// PITCH: translation per turn.
    Screw {
        pitch: f64,
    },
    /// PD: pitch diameter.
    RackPin {
        pitch_diameter: f64,
    },
}

impl JointKind {
    /// Its flag in the statement.
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

    /// PITCH or PD.
    pub(crate) const fn number(self) -> Option<f64> {
        match self {
            Self::Screw { pitch } => Some(pitch),
            Self::RackPin { pitch_diameter } => Some(pitch_diameter),
            _ => None,
        }
    }
}

/// JOINT.
#[derive(Clone, PartialEq, Debug)]
pub struct Joint {
    /// Id, name, origin.
    pub header: Header,
    /// Type.
    pub kind: JointKind,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// IC or ICTRAN of the displacement along zj: value, and rate if given.
    pub initial_translation: Option<(f64, Option<f64>)>,
    /// IC or ICROT of the rotation about zj, radians.
    pub initial_rotation: Option<(f64, Option<f64>)>,
}

/// The type of a JPRIM.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are the manual's.
pub enum PrimitiveKind {
    AtPoint,
    Inline,
    Inplane,
    Orientation,
    ParallelAxes,
    Perpendicular,
}

impl PrimitiveKind {
    /// Its flag in the statement.
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

/// JPRIM.
#[derive(Clone, PartialEq, Debug)]
pub struct Primitive {
    /// Id, name, origin.
    pub header: Header,
    /// Type.
    pub kind: PrimitiveKind,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
}

/// Which displacement of a joint a COUPLER term takes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum CouplerKind {
    /// Along zj.
    Translation,
    /// About zj.
    Rotation,
}

/// COUPLER: sum of scale times joint displacement is zero.
#[derive(Clone, PartialEq, Debug)]
pub struct Coupler {
    /// Id, name, origin.
    pub header: Header,
    /// Index into `Model::joints`, which displacement, scale.
    pub terms: Vec<(usize, CouplerKind, f64)>,
}

/// GEAR.
#[derive(Clone, PartialEq, Debug)]
pub struct Gear {
    /// Id, name, origin.
    pub header: Header,
    /// Indices into `Model::joints`.
    pub joints: [usize; 2],
    /// The common-velocity marker.
    pub cv: MarkerIx,
}

/// GCON: the function is zero.
#[derive(Clone, PartialEq, Debug)]
pub struct Gcon {
    /// Id, name, origin.
    pub header: Header,
    /// I: where the reaction is reported.
    pub i: Option<MarkerIx>,
    /// The constrained function.
    pub function: Function,
}

/// What a MOTION prescribes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum MotionAxis {
    /// Component of the displacement along an axis of J: 0, 1, 2 for X, Y, Z.
    Translation(usize),
    /// Rotation about zj (joint motions).
    RotationZ,
    /// Body-fixed 1-2-3 angle: 0, 1, 2 for B1, B2, B3.
    Body123(usize),
}

impl MotionAxis {
    /// Its flag in the statement.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Translation(axis) => ["X", "Y", "Z"][axis],
            Self::RotationZ => "ROTATIONAL",
            Self::Body123(axis) => ["B1", "B2", "B3"][axis],
        }
    }
}

/// The order of a MOTION.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are the manual's.
pub enum MotionOrder {
    Displacement,
    Velocity,
    Acceleration,
}

/// MOTION, resolved to its markers.
#[derive(Clone, PartialEq, Debug)]
pub struct Motion {
    /// Id, name, origin.
    pub header: Header,
    /// The joint it drives (index into `Model::joints`), if given by joint.
    pub joint: Option<usize>,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// What it prescribes.
    pub axis: MotionAxis,
    /// Displacement, velocity or acceleration.
    pub order: MotionOrder,
    /// ICDISP.
    pub initial_displacement: Option<f64>,
    /// ICVEL.
    pub initial_velocity: Option<f64>,
    /// FUNCTION.
    pub function: Function,
}
