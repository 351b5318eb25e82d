use crate::system::NoValue;

/// Error that ends a motion, with its time.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("at time {time}: {reason}")]
pub struct MotionError {
    /// Time up to which the motion has been computed.
    pub time: f64,
    /// Reason why the motion ends there.
    pub reason: MotionFailure,
}

/// Cause of an error that ends a motion.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum MotionFailure {
    /// An element or a function has no value.
    #[error(transparent)]
    NoValue(#[from] NoValue),
    /// The constraints cannot be satisfied at the start.
    #[error(
        "the initial conditions are inconsistent: {equation} is violated by {violation:.3e}, in length units of the deck or rad"
    )]
    Inconsistent {
        /// Name of the equation with the largest violation.
        equation: String,
        /// Violation in length units or radians.
        violation: f64,
    },
    /// No velocities satisfy the constraints.
    #[error(
        "no velocities satisfy the constraints: {equation} is violated by {violation:.3e}, in length units of the deck or rad, per unit of time"
    )]
    VelocityConflict {
        /// Name of the equation with the largest violation.
        equation: String,
        /// Rate of violation, in length units or radians per unit of time.
        violation: f64,
    },
    /// A constraint equation that was removed as redundant is violated.
    #[error(
        "{equation} was removed as redundant but is now violated by {violation:.3e}, in length units of the deck or rad"
    )]
    RedundantViolated {
        /// Name of the removed equation.
        equation: String,
        /// Violation in length units or radians.
        violation: f64,
    },
    /// A massless motion is not determined by constraints, stiffness or damping.
    #[error(
        "the mass matrix is singular: the motion of {freedom} has no inertia, and no joint, spring or damper determines it"
    )]
    MassSingular {
        /// Name of the part and direction of the motion.
        freedom: String,
    },
    /// A VARIABLE or the rate of an implicit DIFF is not determined by its equation.
    #[error(
        "{what} is undetermined: its equation is not satisfied, and does not depend on its value in this state"
    )]
    Undetermined {
        /// Name of the VARIABLE or DIFF.
        what: String,
    },
    /// A state or an output depends on the rate of an input, because the input moves a massless part.
    #[error("{what} depends on the rate of an input, which state matrices cannot represent")]
    InputRate {
        /// Name of the state or output.
        what: String,
    },
    /// A VARIABLE of a PSTATE is not a function of positions alone.
    #[error(
        "{what} is not a coordinate: it reads velocities, forces or other states, or no position of a part"
    )]
    NoCoordinate {
        /// Name of the VARIABLE.
        what: String,
    },
    /// The eigenvalue iteration does not converge.
    #[error("the eigenvalue iteration does not converge")]
    NoEigenvalues,
    /// The step size became smaller than HMIN.
    #[error("the integration step {step:.3e} is smaller than HMIN; {worst}")]
    StepTooSmall {
        /// Step size with which the integration would have to continue.
        step: f64,
        /// Name of the component with the largest error, or the cause of the failed iteration.
        worst: String,
    },
    /// A piecewise function switches between its pieces too often.
    #[error(
        "the function of {function} switches more than {count} times between two outputs: an IMPACT or IF in it chatters, or DTOUT is too long"
    )]
    Chatter {
        /// Name of the statement that contains the function.
        function: String,
        /// Number of switches allowed between two outputs.
        count: usize,
    },
    /// The constraints leave degrees of freedom, so they do not determine the positions in a kinematic analysis.
    #[error(
        "a kinematic simulation needs a model with zero degrees of freedom, but this model has {freedoms}"
    )]
    NotKinematic {
        /// Number of remaining degrees of freedom.
        freedoms: usize,
    },
    /// A nonholonomic constraint removes a degree of freedom of the velocities, so the positions follow only from an integration.
    #[error(
        "{equation} constrains velocities, so positions follow only from an integration: use DYNAMIC or TRANSIENT"
    )]
    HeldVelocities {
        /// Name of the nonholonomic constraint equation.
        equation: String,
    },
    /// No positions that satisfy the constraints were found.
    #[error(
        "no positions satisfy the constraints: {equation} is violated by {violation:.3e}, in length units of the deck or rad"
    )]
    NoPosition {
        /// Name of the equation with the largest violation.
        equation: String,
        /// Violation in length units or radians.
        violation: f64,
    },
}

impl MotionFailure {
    /// Adds the time at which the motion ends.
    pub(super) fn at(self, time: f64) -> MotionError {
        MotionError { time, reason: self }
    }
}

/// Failure of the Newton iteration of a step.
pub(super) struct NotSettled {
    pub why: String,
    /// True if a function or an element has no value.
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
