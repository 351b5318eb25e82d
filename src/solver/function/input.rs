use crate::model::MarkerIx;

/// State quantity that a program reads.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum Input {
    /// Simulation time, TIME.
    Time,
    /// Analysis mode, MODE: 1 kinematics, 3 initial conditions, 4 dynamics, 5 statics, 6 quasi-statics, 7 linear.
    Mode,
    /// Geometric quantity between markers, such as a displacement or an angle.
    Measure(Measure),
    /// Velocity or acceleration of one marker relative to another; zero in statics.
    Rate(RateMeasure),
    /// Value of a VARIABLE, VARVAL: index into `Model::variables`.
    Variable(usize),
    /// State of a DIFF, DIF: index into `Model::diffs`.
    Dif(usize),
    /// Time derivative of a DIFF, DIF1: index into `Model::diffs`. Zero in statics unless the state is held constant.
    DifRate(usize),
    /// Element of a state or output array, ARYVAL.
    ArrayValue {
        /// Index into `Model::arrays`.
        array: usize,
        /// Element index, from 0.
        element: usize,
    },
    /// Value of a SENSOR, SENVAL: index into `Model::sensors`. Zero until the sensor has triggered.
    SensorValue(usize),
    /// Force of an element, or force between two markers.
    Force(ForceMeasure),
    /// Quantity that the function FRICTION returns for a FRICTION element; zero in statics.
    Friction {
        /// Index into `Model::frictions`.
        friction: usize,
        /// Index of the quantity, from 0 to 25: force and torque (6), coefficients (6), stiction coefficient (1), surface velocities (6),
        /// creep components (6), weight of the velocity term (1).
        which: usize,
    },
}

/// Number of quantities that the function FRICTION can return. Its second argument selects one of them.
pub(super) const FRICTION_NUMBERS: u32 = 26;

/// Geometric quantity of up to three markers. An absent marker stands for the ground frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Measure {
    /// Kind of quantity.
    pub kind: MeasureKind,
    /// I marker; ground if absent. INCANG allows ground here.
    pub i: Option<MarkerIx>,
    /// J marker; ground if absent.
    pub j: Option<MarkerIx>,
    /// K marker; ground if absent.
    pub k: Option<MarkerIx>,
}

/// Kind of quantity of a [`Measure`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum MeasureKind {
    /// DX, DY, DZ (0, 1, 2): displacement of I from J along an axis of K.
    Displacement(usize),
    /// DM: distance between I and J.
    Distance,
    /// AX, AY, AZ (0, 1, 2): projected angle of I relative to J, counted over full turns.
    ProjectedAngle(usize),
    /// One angle of a rotation sequence of I relative to J: PSI, THETA, PHI, YAW, PITCH, ROLL and most types of ORIENT.
    Angle {
        /// Rotation sequence.
        sequence: RotationSequence,
        /// Index of the angle in the sequence, from 0.
        which: usize,
        /// Whether the sign is reversed: PITCH is minus the second angle.
        minus: bool,
    },
    /// INCANG: angle at J between the lines to I and K, counted over full turns. The first nonzero value is positive.
    IncludedAngle,
    /// ORIENT type 27: Euler parameter e0, e1, e2 or e3 of I relative to J, with e0 not negative.
    EulerParameter(usize),
}

impl MeasureKind {
    /// Returns whether the angle counts full turns. The value of such an angle continues from the previous solution.
    pub(crate) fn counts_turns(self) -> bool {
        matches!(self, Self::ProjectedAngle(_) | Self::IncludedAngle)
    }
}

/// Velocity or acceleration of I relative to J. An absent marker stands for the ground frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct RateMeasure {
    /// Kind of vector that is measured.
    pub kind: RateKind,
    /// Component or magnitude of that vector.
    pub axis: RateAxis,
    /// Markers I, J, K (whose axes resolve the vector) and L (the frame of the time derivative).
    pub markers: [Option<MarkerIx>; 4],
}

/// Vector measured by a [`RateMeasure`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum RateKind {
    /// VX, VY, VZ, VM, VR: first time derivative, in the frame of L, of the displacement of I from J.
    Velocity,
    /// WX, WY, WZ, WM: angular velocity of I minus the angular velocity of J.
    AngularVelocity,
    /// ACCX, ACCY, ACCZ, ACCM: second time derivative, in the frame of L, of the displacement of I from J.
    Acceleration,
    /// WDTX, WDTY, WDTZ, WDTM: time derivative, in the frame of L, of the difference of the angular velocities of I and J.
    AngularAcceleration,
}

impl RateKind {
    /// Returns whether the vector is an acceleration or an angular acceleration.
    pub(crate) const fn is_second(self) -> bool {
        matches!(self, Self::Acceleration | Self::AngularAcceleration)
    }
}

/// Component or magnitude of a vector.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum RateAxis {
    /// Component along an axis of K (0, 1, 2).
    Axis(usize),
    /// Magnitude.
    Magnitude,
    /// VR: component along the line from J to I.
    Along,
}

/// Sequence of three rotations, each about the x, y or z axis (0, 1, 2).
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct RotationSequence {
    /// Rotation axes in the order of the rotations.
    pub axes: [usize; 3],
    /// Whether the axes are fixed in space (true) or rotate with the body (false).
    pub space_fixed: bool,
}

/// Component of a force and torque, in the order of the manual's component numbers 1 to 8.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
#[allow(missing_docs)] // The names are those of the manual.
pub enum ForceComponent {
    Fm,
    Fx,
    Fy,
    Fz,
    Tm,
    Tx,
    Ty,
    Tz,
}

impl ForceComponent {
    /// All components, starting with component number 1.
    pub(crate) const ALL: [Self; 8] = [
        Self::Fm,
        Self::Fx,
        Self::Fy,
        Self::Fz,
        Self::Tm,
        Self::Tx,
        Self::Ty,
        Self::Tz,
    ];
}

/// Element whose force is measured, given by its index in a list of the model.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum MeasuredElement {
    /// BUSHING: index into `Model::bushings`.
    Bushing(usize),
    /// FIELD or BEAM: index into `Model::pair_forces`.
    PairForce(usize),
    /// SPRINGDAMPER: index into `Model::springdampers`.
    SpringDamper(usize),
    /// SFORCE: index into `Model::sforces`.
    Sforce(usize),
    /// GFORCE, VFORCE or VTORQUE: index into `Model::vector_forces`.
    VectorForce(usize),
    /// NFORCE, measured at one of its markers.
    Nforce {
        /// Index into `Model::nforces`.
        nforce: usize,
        /// Marker at which the force acts.
        at: MarkerIx,
    },
    /// JOINT: index into `Model::joints`.
    Joint(usize),
    /// JPRIM: index into `Model::primitives`.
    Primitive(usize),
    /// MOTION: index into `Model::motions`.
    Motion(usize),
}

/// Force component that a function measures.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum ForceMeasure {
    /// FM to TZ: force on I, or torque about the I origin, exerted by all elements and constraints that act directly between I and J. If J
    /// is absent, the forces of all elements and constraints that act at I are summed. This is the rule of the C++ solver (`cfunc_fx`); the
    /// FORTRAN solver then counts only action-only forces (`func_fx`).
    Between {
        /// Force or torque component.
        component: ForceComponent,
        /// Marker on which the force acts.
        i: MarkerIx,
        /// Marker J; if absent, all elements and constraints at I are summed.
        j: Option<MarkerIx>,
        /// Marker whose axes resolve the force; ground if absent.
        k: Option<MarkerIx>,
    },
    /// BUSH, JOINT and similar functions: the force of one element.
    Element {
        /// Element that exerts the force.
        element: MeasuredElement,
        /// Whether to measure the force on J at the J origin (jflag 1) instead of the force on I.
        on_j: bool,
        /// Force or torque component.
        component: ForceComponent,
        /// Marker whose axes resolve the force; ground if absent.
        rm: Option<MarkerIx>,
    },
}
