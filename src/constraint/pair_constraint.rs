//! All pair constraints behind one type. Knows no formula.

use super::{Constraint, Convel, Drive, Equations, Locks, RackPinion, Screw};
use crate::mechanics::RelativeMotion;

/// Any constraint between one pair of markers, without a pointer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // Each variant is the constraint of its name.
pub(crate) enum PairConstraint {
    Locks(Locks),
    Convel(Convel),
    Screw(Screw),
    RackPinion(RackPinion),
    Drive(Drive),
}

impl Constraint for PairConstraint {
    fn count(&self) -> usize {
        match self {
            Self::Locks(c) => c.count(),
            Self::Convel(c) => c.count(),
            Self::Screw(c) => c.count(),
            Self::RackPinion(c) => c.count(),
            Self::Drive(c) => c.count(),
        }
    }

    fn parameter_count(&self) -> usize {
        match self {
            Self::Locks(c) => c.parameter_count(),
            Self::Convel(c) => c.parameter_count(),
            Self::Screw(c) => c.parameter_count(),
            Self::RackPinion(c) => c.parameter_count(),
            Self::Drive(c) => c.parameter_count(),
        }
    }

    fn equation_name(&self, k: usize) -> &'static str {
        match self {
            Self::Locks(c) => c.equation_name(k),
            Self::Convel(c) => c.equation_name(k),
            Self::Screw(c) => c.equation_name(k),
            Self::RackPinion(c) => c.equation_name(k),
            Self::Drive(c) => c.equation_name(k),
        }
    }

    fn uses_angles(&self) -> bool {
        match self {
            Self::Locks(c) => c.uses_angles(),
            Self::Convel(c) => c.uses_angles(),
            Self::Screw(c) => c.uses_angles(),
            Self::RackPinion(c) => c.uses_angles(),
            Self::Drive(c) => c.uses_angles(),
        }
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        multipliers: &[f64],
        out: &mut Equations,
    ) {
        match self {
            Self::Locks(c) => c.evaluate(motion, theta, multipliers, out),
            Self::Convel(c) => c.evaluate(motion, theta, multipliers, out),
            Self::Screw(c) => c.evaluate(motion, theta, multipliers, out),
            Self::RackPinion(c) => c.evaluate(motion, theta, multipliers, out),
            Self::Drive(c) => c.evaluate(motion, theta, multipliers, out),
        }
    }
}
