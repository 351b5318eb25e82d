/// The kinds of objects that have results, in the order their values stand in a step.
///
/// Order: that of the maps of the formatted file (guide/formats.md 6.2), which is also the order of the real XRF files of
/// section 12. The names are those of ADAMS/View classes; Part, Joint, Primitive_Joint, Motion, Single_Component_Force,
/// Bushing, Field, Request, ADAMS_Variable, Plant_Input, Plant_Output, Differential_Equation, General_Force,
/// Floating_Marker, Friction and Contact are seen in real files, the others follow from the rule.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[allow(missing_docs)] // Each variant is the class it is called after.
pub enum EntityKind {
    Part,
    PointMass,
    FlexibleBody,
    DifferentialEquation,
    Joint,
    PrimitiveJoint,
    Motion,
    Gear,
    Coupler,
    UserConstraint,
    SingleComponentForce,
    TranslationalSpringDamper,
    RotationalSpringDamper,
    Bushing,
    Beam,
    Field,
    /// A force by a law that no real file was seen with, by the name of its type.
    PairForce(&'static str),
    Request,
    Variable,
    PlantInput,
    PlantOutput,
    TransferFunction,
    LinearStateEquation,
    GeneralStateEquation,
    PointCurve,
    CurveCurve,
    MultiPointForce,
    ForceVector,
    TorqueVector,
    GeneralForce,
    Friction,
    FloatingMarker,
    Contact,
}

/// Which columns the objects of a kind have.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Shape {
    /// X Y Z PSI THETA PHI, then velocities, then accelerations.
    Pose,
    /// X Y Z, then velocities, then accelerations.
    Position,
    /// X Y Z PSI THETA PHI alone.
    Place,
    /// FX FY FZ TX TY TZ.
    Force,
    /// FX FY FZ TX TY TZ ANGX ANGY ANGZ.
    ForceAndAngles,
    /// One value Q.
    Value,
    /// Q and its derivative DQ.
    ValueAndDerivative,
    /// IN1, IN2, ...
    Inputs,
    /// OUT1, OUT2, ...
    Outputs,
    /// Whatever the statement names.
    Named,
}

impl EntityKind {
    /// The kind of a force by a law, from the name of its type.
    pub fn of_law(entity: &'static str) -> Self {
        [
            Self::TranslationalSpringDamper,
            Self::RotationalSpringDamper,
            Self::Bushing,
            Self::Beam,
            Self::Field,
        ]
        .into_iter()
        .find(|kind| kind.ent_type() == entity)
        .unwrap_or(Self::PairForce(entity))
    }

    /// True if its objects have the angles ANGX, ANGY, ANGZ.
    pub const fn has_angles(self) -> bool {
        matches!(self.shape(), Shape::ForceAndAngles)
    }

    /// The attribute `entType`.
    pub const fn ent_type(self) -> &'static str {
        match self {
            Self::Part => "Part",
            Self::PointMass => "Point_Mass",
            Self::FlexibleBody => "Flexible_Body",
            Self::DifferentialEquation => "Differential_Equation",
            Self::Joint => "Joint",
            Self::PrimitiveJoint => "Primitive_Joint",
            Self::Motion => "Motion",
            Self::Gear => "Gear",
            Self::Coupler => "Coupler",
            Self::UserConstraint => "General_Constraint",
            Self::SingleComponentForce => "Single_Component_Force",
            Self::TranslationalSpringDamper => "Translational_Spring_Damper",
            Self::RotationalSpringDamper => "Rotational_Spring_Damper",
            Self::Bushing => "Bushing",
            Self::Beam => "Beam",
            Self::Field => "Field",
            Self::PairForce(name) => name,
            Self::Request => "Request",
            Self::Variable => "ADAMS_Variable",
            Self::PlantInput => "Plant_Input",
            Self::PlantOutput => "Plant_Output",
            Self::TransferFunction => "Transfer_Function",
            Self::LinearStateEquation => "Linear_State_Equation",
            Self::GeneralStateEquation => "General_State_Equation",
            Self::PointCurve => "Point_Curve",
            Self::CurveCurve => "Curve_Curve",
            Self::MultiPointForce => "Multi_Point_Force",
            Self::ForceVector => "Force_Vector",
            Self::TorqueVector => "Torque_Vector",
            Self::GeneralForce => "General_Force",
            Self::Friction => "Friction",
            Self::FloatingMarker => "Floating_Marker",
            Self::Contact => "Contact",
        }
    }

    /// The keyword of the statement behind a class, as the attribute `entType` has it.
    pub fn keyword(ent_type: &str) -> String {
        let keyword = match ent_type {
            "Single_Component_Force" => "SFORCE",
            "Primitive_Joint" => "JPRIM",
            "ADAMS_Variable" => "VARIABLE",
            "Plant_Input" => "PINPUT",
            "Plant_Output" => "POUTPUT",
            "Translational_Spring_Damper" | "Rotational_Spring_Damper" => "SPRINGDAMPER",
            "Differential_Equation" => "DIFF",
            "Force_Vector" => "VFORCE",
            "Torque_Vector" => "VTORQUE",
            "General_Force" => "GFORCE",
            "Multi_Point_Force" => "NFORCE",
            "Floating_Marker" => "MARKER",
            "Flexible_Body" => "FLEX_BODY",
            "General_Constraint" => "GCON",
            other => return other.to_ascii_uppercase(),
        };
        keyword.to_string()
    }

    /// The name of an object that has none in the dataset, for example `PART_2`.
    pub(crate) fn default_name(self, id: i64) -> String {
        let stem = match self {
            Self::SingleComponentForce => "SFORCE",
            Self::PrimitiveJoint => "JPRIM",
            Self::Variable => "VARIABLE",
            Self::PlantInput => "PINPUT",
            Self::PlantOutput => "POUTPUT",
            Self::TranslationalSpringDamper | Self::RotationalSpringDamper => "SPRING",
            Self::DifferentialEquation => "DIFF",
            Self::ForceVector => "VFORCE",
            Self::TorqueVector => "VTORQUE",
            Self::GeneralForce => "GFORCE",
            Self::MultiPointForce => "NFORCE",
            Self::FloatingMarker => "MARKER",
            other => other.ent_type(),
        };
        format!("{}_{id}", stem.to_ascii_uppercase())
    }

    pub(super) const fn shape(self) -> Shape {
        match self {
            Self::Part | Self::FlexibleBody => Shape::Pose,
            Self::PointMass => Shape::Position,
            Self::FloatingMarker => Shape::Place,
            Self::Bushing | Self::Field => Shape::ForceAndAngles,
            Self::DifferentialEquation => Shape::ValueAndDerivative,
            Self::Variable => Shape::Value,
            Self::PlantInput => Shape::Inputs,
            Self::PlantOutput => Shape::Outputs,
            Self::Request
            | Self::TransferFunction
            | Self::LinearStateEquation
            | Self::GeneralStateEquation => Shape::Named,
            _ => Shape::Force,
        }
    }

    /// True for the bodies: their displacements, velocities and accelerations come first in a step.
    pub(crate) const fn is_body(self) -> bool {
        matches!(self, Self::Part | Self::PointMass | Self::FlexibleBody)
    }
}
