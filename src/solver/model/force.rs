use super::{ArrayKind, Function, Header, MarkerIx, Model};
use admire_syntax::Address;
use admire_syntax::car_field::{CarAxis, CarField};
use admire_syntax::grammar::{ArgumentDef, LawDef, StatementDef};

/// BUSHING statement. All components are in J axes.
#[derive(Clone, PartialEq, Debug)]
pub struct Bushing {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// Translational stiffnesses, K.
    pub k: [f64; 3],
    /// Rotational stiffnesses per radian, KT.
    pub kt: [f64; 3],
    /// Translational damping, C.
    pub c: [f64; 3],
    /// Rotational damping per radian, CT.
    pub ct: [f64; 3],
    /// Preload force on I, FORCE.
    pub force: [f64; 3],
    /// Preload torque on I, TORQUE.
    pub torque: [f64; 3],
}

/// Element with six elastic components between two markers: a BUSHING, or a FIELD.
#[derive(Clone, Copy, Debug)]
pub struct ElasticPair<'m> {
    /// Keyword of the statement: `BUSHING` or `FIELD`.
    pub kind: &'static str,
    /// Id and name of the object, and index of its statement.
    pub header: &'m Header,
    /// I marker.
    pub i: MarkerIx,
    /// J marker. The components are along its axes.
    pub j: MarkerIx,
}

impl Model {
    /// Returns the name that results use for a FIELD of Adams/Car or one of its components: `axle.bkl_arm_outer` for `FIELD/9`, and
    /// `axle.bkl_arm_outer.fx` for `FIELD/9.FX`. Returns `None` for another address.
    pub fn car_name(&self, address: &str) -> Option<String> {
        let (id, component) = match address.strip_prefix("FIELD/")?.split_once('.') {
            Some((id, word)) => (id, Some(word)),
            None => (address.strip_prefix("FIELD/")?, None),
        };
        let id: u32 = id.parse().ok()?;
        let mut fields = self.pair_forces.iter();
        let car = fields
            .find(|f| f.is_field() && f.header.id == id)?
            .car
            .as_ref()?;
        let Some(word) = component else {
            return Some(car.bushing.clone());
        };
        let axis = admire_syntax::FORCE_COMPONENTS
            .iter()
            .position(|own| *own == word)?;
        Some(car.axis(axis))
    }

    /// Iterates over all BUSHINGs, then over all FIELDs.
    pub fn elastic_pairs(&self) -> impl Iterator<Item = ElasticPair<'_>> {
        let bushings = self.bushings.iter().map(|bushing| ElasticPair {
            kind: "BUSHING",
            header: &bushing.header,
            i: bushing.i,
            j: bushing.j,
        });
        let fields = self.pair_forces.iter();
        let fields = fields.filter(|force| force.is_field());
        bushings.chain(fields.map(|field| ElasticPair {
            kind: "FIELD",
            header: &field.header,
            i: field.i,
            j: field.j,
        }))
    }
}

/// Force between two markers whose law and parameters are defined by the grammar (FIELD, BEAM).
#[derive(Clone, PartialEq, Debug)]
pub struct PairForce {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Definition of the statement in the grammar.
    pub def: &'static StatementDef,
    /// Force law: one of the laws that the grammar defines for the statement.
    pub law: &'static LawDef,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// Parameters of the law: the values of its arguments, in the order of the law.
    pub values: Vec<f64>,
    /// Values of the damping matrix CMATRIX in the order of the statement; empty if not given.
    pub damping: Vec<f64>,
    /// Ratio of damping to stiffness, CRATIO.
    pub damping_ratio: f64,
    /// Curves and arrays of a FIELD that Adams/Car writes for a bushing; `values` is then empty.
    pub car: Option<CarField>,
}

impl PairForce {
    /// Returns the parameters that belong to one argument of the law.
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

    /// Returns true for a FIELD.
    pub fn is_field(&self) -> bool {
        self.def.name == "FIELD"
    }

    /// Returns the parameter that moves the free position of a FIELD along one component (0 to 5), and its change per unit of displacement: an
    /// element of LENGTH, or the offset in an array of Adams/Car. Returns `None` for another force, or for an array that cannot be read.
    pub fn free_position(&self, model: &Model, axis: usize) -> Option<(Address, f64)> {
        if !self.is_field() {
            return None;
        }
        let Some(car) = &self.car else {
            let id = self.header.id;
            return Some((
                Address::of_argument("FIELD", id, "LENGTH", Some(axis + 1)),
                1.0,
            ));
        };
        let offset = car.parameter(axis, CarAxis::OFFSET);
        Some((offset, self.car_axis(model, axis)?.stretch))
    }

    /// Returns the parameter that scales the force of a FIELD along one component (0 to 5), and its value: a diagonal element of KMATRIX, or the
    /// scale in an array of Adams/Car. Returns `None` for another force, or for an array that cannot be read.
    pub fn stiffness_scale(&self, model: &Model, axis: usize) -> Option<(Address, f64)> {
        if !self.is_field() {
            return None;
        }
        let Some(car) = &self.car else {
            let (id, at) = (self.header.id, 7 * axis);
            let value = *self.argument("KMATRIX")?.get(at)?;
            return Some((
                Address::of_argument("FIELD", id, "KMATRIX", Some(at + 1)),
                value,
            ));
        };
        let scale = car.parameter(axis, CarAxis::SCALE);
        Some((scale, self.car_axis(model, axis)?.scale))
    }

    /// Returns the values of one array of a bushing of Adams/Car. Returns `None` for another force, or for an array that cannot be read.
    pub fn car_axis(&self, model: &Model, axis: usize) -> Option<CarAxis> {
        let id = self.car.as_ref()?.arrays[axis];
        let array = model.arrays.iter().find(|array| array.header.id == id)?;
        match &array.kind {
            ArrayKind::Numbers(numbers) => CarAxis::read(numbers).ok(),
            _ => None,
        }
    }
}

/// Returns the arguments of a statement that hold the parameters of a law, in the order of the law.
pub(crate) fn law_arguments(
    def: &'static StatementDef,
    law: &'static LawDef,
) -> impl Iterator<Item = &'static ArgumentDef> {
    law.arguments.iter().filter_map(|name| def.argument(name))
}

/// Type of a SPRINGDAMPER.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SpringKind {
    /// Spring along the line between the marker origins; arguments K, LENGTH, FORCE.
    Translational,
    /// Torsion spring about zj; arguments KT, ANGLE, TORQUE.
    Rotational,
}

/// SPRINGDAMPER statement.
#[derive(Clone, PartialEq, Debug)]
pub struct SpringDamper {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// Type of the spring.
    pub kind: SpringKind,
    /// Stiffness, K or KT.
    pub stiffness: f64,
    /// Reference length or angle at which only the preload acts, LENGTH or ANGLE.
    pub reference: f64,
    /// Preload at the reference, FORCE or TORQUE.
    pub preload: f64,
    /// Damping, C or CT.
    pub damping: f64,
}

/// Type of an SFORCE.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SforceKind {
    /// Force along the line between the marker origins, or along zj if action-only.
    Translational,
    /// Torque about zj.
    Rotational,
}

/// SFORCE statement.
#[derive(Clone, PartialEq, Debug)]
pub struct Sforce {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// I marker.
    pub i: MarkerIx,
    /// J marker.
    pub j: MarkerIx,
    /// Type of the force.
    pub kind: SforceKind,
    /// ACTIONONLY: no reaction acts on J.
    pub action_only: bool,
    /// FUNCTION: the magnitude of the force.
    pub function: Function,
}

/// Kind of statement that defines a vector force.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are those of the manual.
pub enum VectorForceKind {
    Gforce,
    Vforce,
    Vtorque,
}

/// GFORCE, VFORCE or VTORQUE: force or torque at I with components in RM axes. The reaction acts on the part of JFLOAT at the position of
/// I.
#[derive(Clone, PartialEq, Debug)]
pub struct VectorForce {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Statement kind.
    pub kind: VectorForceKind,
    /// I marker.
    pub i: MarkerIx,
    /// JFLOAT marker.
    pub jfloat: MarkerIx,
    /// RM marker; ground axes if absent.
    pub rm: Option<MarkerIx>,
    /// Components FX, FY, FZ, TX, TY, TZ. Absent components are zero.
    pub components: [Option<Function>; 6],
}

/// NFORCE: forces on several markers, given by a stiffness matrix and their deflections relative to a reference marker.
#[derive(Clone, PartialEq, Debug)]
pub struct Nforce {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// I markers.
    pub i: Vec<MarkerIx>,
    /// J marker, the reference.
    pub j: MarkerIx,
    /// KMATRIX, (6n)^2 values column by column.
    pub k: Vec<f64>,
    /// LENGTH, 6n values.
    pub length: Vec<f64>,
    /// FORCE, 6n values.
    pub force: Vec<f64>,
    /// Damping matrix, (6n)^2 values column by column: CMATRIX, or CRATIO times KMATRIX. Empty without damping.
    pub damping: Vec<f64>,
}
