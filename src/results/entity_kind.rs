/// The kinds of objects that have results, in the order in which their values are stored in an output step.
///
/// The order follows the maps of the formatted file (guide/formats.md 6.2); the real XRF files of section 12 have the same order. The names
/// are class names of ADAMS/View.
///
/// Real files contain Part, Joint, Primitive_Joint, Motion, Single_Component_Force, Bushing, Field, Request, ADAMS_Variable, Plant_Input,
/// Plant_Output, Differential_Equation, General_Force, Floating_Marker, Friction and Contact. The other names follow the same pattern.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[allow(missing_docs)] // Each variant is named after its class.
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
    /// A force between two markers with a law that no known real results file contains. The text is the `entType` name of the law.
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

/// The set of result columns that objects of one kind have.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Shape {
    /// X Y Z PSI THETA PHI, then their velocities, then their accelerations.
    Pose,
    /// X Y Z, then their velocities, then their accelerations.
    Position,
    /// X Y Z PSI THETA PHI, without velocities and accelerations.
    Place,
    /// FX FY FZ TX TY TZ.
    Force,
    /// FX FY FZ TX TY TZ ANGX ANGY ANGZ.
    ForceAndAngles,
    /// Q, a single value.
    Value,
    /// Q, and its time derivative DQ.
    ValueAndDerivative,
    /// IN1, IN2, ..., one column for each input variable.
    Inputs,
    /// OUT1, OUT2, ..., one column for each output variable.
    Outputs,
    /// Columns whose names the statement gives.
    Named,
}

impl EntityKind {
    /// Returns the kind of a force from the `entType` name of its law. A name that no other kind has gives [`Self::PairForce`].
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

    /// Returns true if objects of this kind have the angle columns ANGX, ANGY, ANGZ.
    pub const fn has_angles(self) -> bool {
        matches!(self.shape(), Shape::ForceAndAngles)
    }

    /// Returns the `entType` attribute that objects of this kind have in XRF files.
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

    /// Returns the statement keyword that belongs to an `entType` attribute, for example `SFORCE` for `Single_Component_Force`.
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

    /// Returns the name for an object that has no ADAMS/View name in the dataset, for example `PART_2`.
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

    /// Returns true for bodies. The displacements, velocities and accelerations of bodies come first in an output step.
    pub(crate) const fn is_body(self) -> bool {
        matches!(self, Self::Part | Self::PointMass | Self::FlexibleBody)
    }
}
