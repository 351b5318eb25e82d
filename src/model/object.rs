use super::{
    ArrayData, Bushing, Coupler, Diff, Friction, Gcon, Gear, Header, Joint, LinearStates, Marker,
    Motion, Nforce, PairForce, Part, PartKind, PlantPort, Primitive, Request, Sensor, Sforce,
    Spline, SpringDamper, StringData, Variable, VectorForce, VectorForceKind,
};

/// What every object of a model has.
pub(super) trait Object {
    /// Its header.
    fn header(&self) -> &Header;
    /// Its header, to change it.
    fn header_mut(&mut self) -> &mut Header;
    /// True if the object comes from this kind of statement; lists of one kind only always say so.
    fn is(&self, kind: &str) -> bool;
}

macro_rules! objects {
    ($($type:ty: |$object:ident, $kind:ident| $is:expr,)+) => {
        $(impl Object for $type {
            fn header(&self) -> &Header {
                &self.header
            }
            fn header_mut(&mut self) -> &mut Header {
                &mut self.header
            }
            fn is(&self, $kind: &str) -> bool {
                let $object = self;
                $is
            }
        })+
    };
}

objects! {
    Part: |part, kind| match part.kind {
        PartKind::Ground | PartKind::Rigid => kind == "PART",
        PartKind::PointMass => kind == "POINT_MASS",
        PartKind::External => kind == "FLEX_BODY" || kind == "FE_PART",
    },
    VectorForce: |force, kind| kind == match force.kind {
        VectorForceKind::Gforce => "GFORCE",
        VectorForceKind::Vforce => "VFORCE",
        VectorForceKind::Vtorque => "VTORQUE",
    },
    PairForce: |force, kind| force.def.name == kind,
    LinearStates: |states, kind| states.kind == kind,
    PlantPort: |port, kind| port.kind == kind,
    Marker: |_marker, _kind| true,
    Joint: |_joint, _kind| true,
    Primitive: |_primitive, _kind| true,
    Coupler: |_coupler, _kind| true,
    Gear: |_gear, _kind| true,
    Friction: |_friction, _kind| true,
    Gcon: |_gcon, _kind| true,
    Motion: |_motion, _kind| true,
    Bushing: |_bushing, _kind| true,
    SpringDamper: |_springdamper, _kind| true,
    Sforce: |_sforce, _kind| true,
    Nforce: |_nforce, _kind| true,
    Variable: |_variable, _kind| true,
    Diff: |_diff, _kind| true,
    ArrayData: |_array, _kind| true,
    Spline: |_spline, _kind| true,
    StringData: |_string, _kind| true,
    Sensor: |_sensor, _kind| true,
    Request: |_request, _kind| true,
}
