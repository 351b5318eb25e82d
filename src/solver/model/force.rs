use super::{Function, Header, MarkerIx};
use admire_syntax::grammar::{ArgumentDef, LawDef, StatementDef};

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
    /// C.
    pub c: [f64; 3],
    /// CT, per radian.
    pub ct: [f64; 3],
    /// FORCE: preload on I.
    pub force: [f64; 3],
    /// TORQUE: preload on I.
    pub torque: [f64; 3],
}

/// A force between two markers by a law whose numbers the grammar names: FIELD, BEAM.
#[derive(Clone, PartialEq, Debug)]
pub struct PairForce {
    /// Id, name, origin.
    pub header: Header,
    /// Its statement.
    pub def: &'static StatementDef,
    /// Its law, one of the statement's.
    pub law: &'static LawDef,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// The numbers of the law: the values of its arguments, one argument after the other.
    pub values: Vec<f64>,
    /// CMATRIX as written, or empty.
    pub damping: Vec<f64>,
    /// CRATIO.
    pub damping_ratio: f64,
}

impl PairForce {
    /// The numbers that come from one argument of the law.
    pub fn argument(&self, name: &str) -> Option<&[f64]> {
        let mut first = 0;
        for argument in law_arguments(self.def, self.law) {
            let count = argument.count.max.unwrap_or(0);
            if argument.name == name {
                return self.values.get(first..first + count);
            }
            first += count;
        }
        None
    }
}

/// The arguments of a statement that hold the numbers of a law, in its order.
pub(crate) fn law_arguments(
    def: &'static StatementDef,
    law: &'static LawDef,
) -> impl Iterator<Item = &'static ArgumentDef> {
    law.arguments.iter().filter_map(|name| def.argument(name))
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
    /// C or CT.
    pub damping: f64,
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
    /// Damping, (6n)^2 values column by column: CMATRIX, or CRATIO times KMATRIX. Empty if there is none.
    pub damping: Vec<f64>,
}
