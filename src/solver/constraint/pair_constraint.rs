//! Common enum type of all pair constraints. The module contains no formulas.

use super::{Constraint, Convel, Drive, Equations, Locks, RackPinion, Screw};
use crate::mechanics::RelativeMotion;

/// Any constraint between one pair of markers, stored by value (not boxed).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // Each variant is named after its constraint.
pub(crate) enum PairConstraint {
    Locks(Locks),
    Convel(Convel),
    Screw(Screw),
    RackPinion(RackPinion),
    Drive(Drive),
}

impl PairConstraint {
    fn own(&self) -> &dyn Constraint {
        match self {
            Self::Locks(c) => c,
            Self::Convel(c) => c,
            Self::Screw(c) => c,
            Self::RackPinion(c) => c,
            Self::Drive(c) => c,
        }
    }
}

impl Constraint for PairConstraint {
    fn count(&self) -> usize {
        self.own().count()
    }

    fn parameter_count(&self) -> usize {
        self.own().parameter_count()
    }

    fn equation_name(&self, k: usize) -> &'static str {
        self.own().equation_name(k)
    }

    fn uses_angles(&self) -> bool {
        self.own().uses_angles()
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        multipliers: &[f64],
        out: &mut Equations,
    ) {
        self.own().evaluate(motion, theta, multipliers, out);
    }
}
