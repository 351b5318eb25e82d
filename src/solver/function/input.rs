use crate::model::MarkerIx;

/// A state quantity that a program reads.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum Input {
    /// TIME.
    Time,
    /// MODE: 1 kinematics, 3 initial conditions, 4 dynamics, 5 statics, 6 quasi-statics, 7 linear.
    Mode,
    /// A geometric quantity of markers.
    Measure(Measure),
    /// A velocity or acceleration of markers: zero in statics.
    Rate(RateMeasure),
    /// VARVAL: index into `Model::variables`.
    Variable(usize),
    /// DIF: index into `Model::diffs`.
    Dif(usize),
    /// DIF1, the time derivative of a DIF: index into `Model::diffs`. Zero in statics unless the state is held.
    DifRate(usize),
    /// ARYVAL of a state or output array: index into `Model::arrays` and which element, from 0.
    ArrayValue {
        /// Index into `Model::arrays`.
        array: usize,
        /// Which element, from 0.
        element: usize,
    },
    /// SENVAL: index into `Model::sensors`. Zero until the sensor has fired.
    SensorValue(usize),
    /// A force of an element or between two markers.
    Force(ForceMeasure),
    /// FRICTION: zero in statics.
    Friction {
        /// Index into `Model::frictions`.
        friction: usize,
        /// Which number, from 0: force and torque, coefficients, that of stiction, surface velocities, creeps, the share of the velocity.
        which: usize,
    },
}

/// How many numbers FRICTION gives: as many as its component of a result has.
pub(super) const FRICTION_NUMBERS: u32 = 26;

/// A geometric quantity of up to three markers. An absent marker is the ground frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Measure {
    /// What is measured.
    pub kind: MeasureKind,
    /// The I marker; ground if absent (INCANG may name ground).
    pub i: Option<MarkerIx>,
    /// The J marker.
    pub j: Option<MarkerIx>,
    /// The K marker.
    pub k: Option<MarkerIx>,
}

/// What a [`Measure`] measures.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum MeasureKind {
    /// DX, DY, DZ: component 0, 1, 2 of the displacement of I from J along an axis of K.
    Displacement(usize),
    /// DM: the distance of I from J.
    Distance,
    /// AX, AY, AZ: projected angle 0, 1, 2 of I with respect to J, counting turns.
    ProjectedAngle(usize),
    /// One angle of a rotation sequence of I with respect to J: PSI, THETA, PHI, YAW, PITCH, ROLL and most of ORIENT.
    Angle {
        /// The sequence.
        sequence: Sequence,
        /// Which angle, from 0.
        which: usize,
        /// PITCH is minus the second angle.
        minus: bool,
    },
    /// INCANG: the angle at J between the lines to I and K; the first that is not zero is positive, and turns are counted.
    IncludedAngle,
    /// ORIENT type 27: Euler parameter e0, e1, e2, e3 of I with respect to J, e0 not negative.
    EulerParameter(usize),
}

impl MeasureKind {
    /// True if the value goes on from that of the solution before.
    pub(crate) fn counts_turns(self) -> bool {
        matches!(self, Self::ProjectedAngle(_) | Self::IncludedAngle)
    }
}

/// A velocity or acceleration of I from J. An absent marker is the ground frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct RateMeasure {
    /// Which vector.
    pub kind: RateKind,
    /// Which number of it.
    pub axis: RateAxis,
    /// I, J, K whose axes resolve it, L in which the derivative is taken.
    pub markers: [Option<MarkerIx>; 4],
}

/// Which vector a [`RateMeasure`] measures.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum RateKind {
    /// VX, VY, VZ, VM, VR: the first derivative of the displacement of I from J in the frame of L.
    Velocity,
    /// WX, WY, WZ, WM: the angular velocity of I less that of J.
    AngularVelocity,
    /// ACCX, ACCY, ACCZ, ACCM: the second derivative of the displacement in the frame of L.
    Acceleration,
    /// WDTX, WDTY, WDTZ, WDTM: the derivative of the difference of the angular velocities in the frame of L.
    AngularAcceleration,
}

impl RateKind {
    /// True for accelerations.
    pub(crate) const fn is_second(self) -> bool {
        matches!(self, Self::Acceleration | Self::AngularAcceleration)
    }
}

/// Which number of a vector.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum RateAxis {
    /// Along an axis of K.
    Axis(usize),
    /// Its length.
    Magnitude,
    /// VR: along the line from J to I.
    Along,
}

/// A sequence of three rotations about axes 0, 1, 2.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Sequence {
    /// The axes in the order they are turned about.
    pub axes: [usize; 3],
    /// True if the axes stay in space, false if they move with the body.
    pub space_fixed: bool,
}

/// A component of a force and torque, in the order of the manual's component numbers 1 to 8.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
#[allow(missing_docs)] // The names are the manual's.
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
    /// All, component number 1 first.
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

/// The element a force measure asks; indices into the lists of the model.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum ElementIx {
    /// `Model::bushings`.
    Bushing(usize),
    /// `Model::pair_forces`: FIELD, BEAM.
    PairForce(usize),
    /// `Model::springdampers`.
    SpringDamper(usize),
    /// `Model::sforces`.
    Sforce(usize),
    /// `Model::vector_forces`: GFORCE, VFORCE, VTORQUE.
    VectorForce(usize),
    /// `Model::nforces`, at one of its markers.
    Nforce {
        /// Index into `Model::nforces`.
        nforce: usize,
        /// The marker the force acts at.
        at: MarkerIx,
    },
    /// `Model::joints`.
    Joint(usize),
    /// `Model::primitives`.
    Primitive(usize),
    /// `Model::motions`.
    Motion(usize),
}

/// A component of a force.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum ForceMeasure {
    /// FX to TM: the force on I, or torque about the I origin, by all elements and constraints that act directly between I and J;
    /// with J absent, by all that act at I (C++ solver, `cfunc_fx`; the FORTRAN solver counts action-only forces there, `func_fx`).
    Between {
        /// Which component.
        component: ForceComponent,
        /// The marker that feels the force.
        i: MarkerIx,
        /// The other marker.
        j: Option<MarkerIx>,
        /// The marker whose axes resolve it; ground if absent.
        k: Option<MarkerIx>,
    },
    /// BUSH, JOINT and so on: the force of one element.
    Element {
        /// The element.
        element: ElementIx,
        /// jflag: the force on J at the J origin instead of that on I.
        on_j: bool,
        /// Which component.
        component: ForceComponent,
        /// The marker whose axes resolve it; ground if absent.
        rm: Option<MarkerIx>,
    },
}
