use super::{
    ArrayData, Bushing, Coupler, Diff, Friction, Gcon, Gear, Header, Joint, LinearStates, Marker,
    Model, Motion, Nforce, PairForce, Part, PartKind, PlantPort, Primitive, Request, Sensor,
    Sforce, Spline, SpringDamper, StringData, Variable, VectorForce, VectorForceKind,
};

/// Interface common to all objects of a model.
pub(super) trait Object {
    /// Returns the header of the object.
    fn header(&self) -> &Header;
    /// Returns the header of the object for modification.
    fn header_mut(&mut self) -> &mut Header;
    /// Returns whether a statement of this kind defined the object.
    fn is(&self, kind: &str) -> bool;
    /// Returns false if statements of this kind never define objects of this type. The list of these objects, which is long in large decks, is then
    /// not scanned.
    fn may_be(_kind: &str) -> bool {
        true
    }
}

macro_rules! objects {
    ($($type:ty: $($word:literal)|+ $(, |$object:ident, $kind:ident| $is:expr)?;)+) => {
        $(impl Object for $type {
            fn header(&self) -> &Header {
                &self.header
            }
            fn header_mut(&mut self) -> &mut Header {
                &mut self.header
            }
            fn is(&self, kind: &str) -> bool {
                Self::may_be(kind) $(&& {
                    let ($object, $kind) = (self, kind);
                    $is
                })?
            }
            fn may_be(kind: &str) -> bool {
                matches!(kind, $($word)|+)
            }
        })+
    };
}

objects! {
    Part: "PART" | "POINT_MASS" | "FLEX_BODY" | "FE_PART", |part, kind| match part.kind {
        PartKind::Ground | PartKind::Rigid => kind == "PART",
        PartKind::PointMass => kind == "POINT_MASS",
        PartKind::External => kind == "FLEX_BODY" || kind == "FE_PART",
    };
    VectorForce: "GFORCE" | "VFORCE" | "VTORQUE", |force, kind| kind == match force.kind {
        VectorForceKind::Gforce => "GFORCE",
        VectorForceKind::Vforce => "VFORCE",
        VectorForceKind::Vtorque => "VTORQUE",
    };
    PlantPort: "PINPUT" | "POUTPUT" | "PSTATE", |port, kind| port.kind == kind;
    LinearStates: "LSE" | "TFSISO", |states, kind| states.kind == kind;
    Marker: "MARKER";
    Joint: "JOINT";
    Primitive: "JPRIM";
    Coupler: "COUPLER";
    Gear: "GEAR";
    Friction: "FRICTION";
    Gcon: "GCON";
    Motion: "MOTION";
    Bushing: "BUSHING";
    SpringDamper: "SPRINGDAMPER";
    Sforce: "SFORCE";
    Nforce: "NFORCE";
    Variable: "VARIABLE";
    Diff: "DIFF";
    ArrayData: "ARRAY";
    Spline: "SPLINE";
    StringData: "STRING";
    Sensor: "SENSOR";
    Request: "REQUEST";
}

impl Object for PairForce {
    fn header(&self) -> &Header {
        &self.header
    }
    fn header_mut(&mut self) -> &mut Header {
        &mut self.header
    }
    fn is(&self, kind: &str) -> bool {
        self.def.name == kind
    }
}

/// Operation on every object list of a model, together with the corresponding list of another model.
pub(super) trait EachList {
    /// Performs the operation on one list and the corresponding list of the other model.
    fn list<T: Object>(&mut self, list: &mut Vec<T>, other: &mut Vec<T>);
}

impl Model {
    /// Applies an operation to all object lists of this model and of `other`.
    pub(super) fn each_list(&mut self, other: &mut Self, each: &mut impl EachList) {
        each.list(&mut self.parts, &mut other.parts);
        each.list(&mut self.markers, &mut other.markers);
        each.list(&mut self.joints, &mut other.joints);
        each.list(&mut self.primitives, &mut other.primitives);
        each.list(&mut self.couplers, &mut other.couplers);
        each.list(&mut self.gears, &mut other.gears);
        each.list(&mut self.frictions, &mut other.frictions);
        each.list(&mut self.gcons, &mut other.gcons);
        each.list(&mut self.motions, &mut other.motions);
        each.list(&mut self.bushings, &mut other.bushings);
        each.list(&mut self.pair_forces, &mut other.pair_forces);
        each.list(&mut self.springdampers, &mut other.springdampers);
        each.list(&mut self.sforces, &mut other.sforces);
        each.list(&mut self.vector_forces, &mut other.vector_forces);
        each.list(&mut self.nforces, &mut other.nforces);
        each.list(&mut self.variables, &mut other.variables);
        each.list(&mut self.diffs, &mut other.diffs);
        each.list(&mut self.linear_states, &mut other.linear_states);
        each.list(&mut self.arrays, &mut other.arrays);
        each.list(&mut self.splines, &mut other.splines);
        each.list(&mut self.strings, &mut other.strings);
        each.list(&mut self.sensors, &mut other.sensors);
        each.list(&mut self.plant_ports, &mut other.plant_ports);
        each.list(&mut self.requests, &mut other.requests);
        each.list(&mut self.unsolved, &mut other.unsolved);
    }
}
