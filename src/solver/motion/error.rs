use crate::system::NoValue;

/// Why a motion ends, and when.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("at time {time}: {reason}")]
pub struct MotionError {
    /// The time up to which everything is computed.
    pub time: f64,
    /// Why it does not go on.
    pub reason: MotionFailure,
}

/// Why a motion ends.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum MotionFailure {
    /// An element or a function has no value.
    #[error(transparent)]
    NoValue(#[from] NoValue),
    /// The constraints cannot be satisfied.
    #[error("the initial conditions are inconsistent: {equation} is violated by {violation:.3e}")]
    Inconsistent {
        /// The worst equation.
        equation: String,
        /// Length units or radians.
        violation: f64,
    },
    /// No velocities satisfy the constraints.
    #[error(
        "no velocities satisfy the constraints: {equation} is violated by {violation:.3e} per time"
    )]
    VelocityConflict {
        /// The worst equation.
        equation: String,
        /// Length units or radians per time.
        violation: f64,
    },
    /// A constraint that was taken for redundant is not.
    #[error("{equation} was redundant and is violated by {violation:.3e} now")]
    RedundantViolated {
        /// The equation.
        equation: String,
        /// Length units or radians.
        violation: f64,
    },
    /// A motion has no mass and nothing that determines it.
    #[error(
        "the mass matrix is singular: {freedom} has no inertia and nothing determines its acceleration"
    )]
    MassSingular {
        /// Part and direction.
        freedom: String,
    },
    /// A VARIABLE or the rate of an implicit DIFF does not follow from its equation.
    #[error(
        "{what} is not determined: its equation does not hold, and does not change with it here"
    )]
    Undetermined {
        /// The statement.
        what: String,
    },
    /// An input moves something without mass: what depends on its velocity depends on the rate of the input.
    #[error("{what} depends on the rate of an input, which state matrices do not have")]
    InputRate {
        /// A state or an output.
        what: String,
    },
    /// A VARIABLE of a PSTATE is not a function of places alone.
    #[error(
        "{what} is no coordinate: it reads velocities, forces, other states or no place of a part"
    )]
    NoCoordinate {
        /// The variable.
        what: String,
    },
    /// The iteration for the eigenvalues does not converge.
    #[error("the eigenvalues of small motions are not found: the iteration does not converge")]
    NoEigenvalues,
    /// The step became smaller than HMIN.
    #[error("the integration step {step:.3e} is smaller than HMIN; {worst}")]
    StepTooSmall {
        /// The step that would be needed.
        step: f64,
        /// What errs most, or what the iteration does not settle.
        worst: String,
    },
    /// A function that is not smooth changes its piece over and over.
    #[error(
        "the function of {function} switches more than {count} times between two outputs: an IMPACT, an IF or the like in it chatters, or DTOUT is long"
    )]
    Chatter {
        /// The statement.
        function: String,
        /// How often it may.
        count: usize,
    },
    /// The positions do not follow from the constraints.
    #[error(
        "the model has {freedoms} degrees of freedom: its positions do not follow from its motions alone"
    )]
    NotKinematic {
        /// How many.
        freedoms: usize,
    },
    /// A constraint of velocities takes a freedom: its place follows from no constraint.
    #[error(
        "{equation} holds velocities: the positions follow from an integration alone, as DYNAMIC and TRANSIENT make it"
    )]
    HeldVelocities {
        /// The constraint.
        equation: String,
    },
    /// Positions could not be found.
    #[error("no positions satisfy the constraints: {equation} is violated by {violation:.3e}")]
    NoPosition {
        /// The worst equation.
        equation: String,
        /// Length units or radians.
        violation: f64,
    },
}

impl MotionFailure {
    /// With its time.
    pub(super) fn at(self, time: f64) -> MotionError {
        MotionError { time, reason: self }
    }
}

/// The iteration of a step does not settle, and why.
pub(super) struct NotSettled {
    pub why: String,
    /// A function or an element has no value.
    pub no_value: bool,
}

impl NotSettled {
    pub(crate) fn at(why: &str) -> Self {
        Self {
            why: why.to_string(),
            no_value: false,
        }
    }
}
