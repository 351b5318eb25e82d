use super::{Function, Header, MarkerIx};

/// BUSHING. All components in J axes.
#[derive(Clone, PartialEq, Debug)]
pub struct Bushing {
    /// Id, name, origin.
    pub header: Header,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// K.
    pub k: [f64; 3],
    /// KT, per radian.
    pub kt: [f64; 3],
    /// FORCE: preload on I.
    pub force: [f64; 3],
    /// TORQUE: preload on I.
    pub torque: [f64; 3],
}

/// FIELD, linear.
#[derive(Clone, PartialEq, Debug)]
pub struct Field {
    /// Id, name, origin.
    pub header: Header,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// KMATRIX, 36 values column by column.
    pub k: [f64; 36],
    /// LENGTH: x0, y0, z0, a0, b0, c0.
    pub length: [f64; 6],
    /// FORCE: preload on I.
    pub force: [f64; 6],
}

/// FORMULATION of a BEAM.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[allow(missing_docs)] // The names are the manual's.
pub enum BeamFormulation {
    #[default]
    Linear,
    String,
    Nonlinear,
}

/// BEAM. Its axis is the x axis of J.
#[derive(Clone, PartialEq, Debug)]
pub struct Beam {
    /// Id, name, origin.
    pub header: Header,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// LENGTH, AREA, IXX, IYY, IZZ, EMODULUS, GMODULUS, ASY, ASZ.
    pub properties: [f64; 9],
    /// FORMULATION.
    pub formulation: BeamFormulation,
}

/// The two kinds of SPRINGDAMPER.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SpringKind {
    /// Along the line of the origins; K, LENGTH, FORCE.
    Translational,
    /// About zj; KT, ANGLE, TORQUE.
    Rotational,
}

/// SPRINGDAMPER.
#[derive(Clone, PartialEq, Debug)]
pub struct SpringDamper {
    /// Id, name, origin.
    pub header: Header,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// Kind.
    pub kind: SpringKind,
    /// K or KT.
    pub stiffness: f64,
    /// LENGTH or ANGLE: where the preload acts alone.
    pub reference: f64,
    /// FORCE or TORQUE at the reference.
    pub preload: f64,
}

/// The two kinds of SFORCE.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SforceKind {
    /// Along the line of the origins, or along zj if action-only.
    Translational,
    /// About zj.
    Rotational,
}

/// SFORCE.
#[derive(Clone, PartialEq, Debug)]
pub struct Sforce {
    /// Id, name, origin.
    pub header: Header,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// Kind.
    pub kind: SforceKind,
    /// ACTIONONLY: nothing acts on J.
    pub action_only: bool,
    /// FUNCTION.
    pub function: Function,
}

/// Which statement a vector force was.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are the manual's.
pub enum VectorForceKind {
    Gforce,
    Vforce,
    Vtorque,
}

/// GFORCE, VFORCE or VTORQUE: components in RM axes, applied at I, reaction at the place of I on the part of JFLOAT.
#[derive(Clone, PartialEq, Debug)]
pub struct VectorForce {
    /// Id, name, origin.
    pub header: Header,
    /// Which statement it was.
    pub kind: VectorForceKind,
    /// I marker.
    pub i: MarkerIx,
    /// JFLOAT marker.
    pub jfloat: MarkerIx,
    /// RM marker; ground axes if absent.
    pub rm: Option<MarkerIx>,
    /// FX, FY, FZ, TX, TY, TZ; absent ones are zero.
    pub components: [Option<Function>; 6],
}

/// NFORCE: forces on several markers from a stiffness matrix about a reference marker.
#[derive(Clone, PartialEq, Debug)]
pub struct Nforce {
    /// Id, name, origin.
    pub header: Header,
    /// The I markers.
    pub i: Vec<MarkerIx>,
    /// The J marker.
    pub j: MarkerIx,
    /// KMATRIX, (6n)^2 values column by column.
    pub k: Vec<f64>,
    /// LENGTH, 6n values.
    pub length: Vec<f64>,
    /// FORCE, 6n values.
    pub force: Vec<f64>,
}
