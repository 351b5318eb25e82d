//! MOTION as a constraint equation on a displacement. The caller evaluates the FUNCTION, and integrates or rejects a MOTION that prescribes
//! a velocity or an acceleration.

use super::{Constraint, Equations, RelativeCoordinate};
use crate::mechanics::{RelativeMotion, Vec6};

/// MOTION in displacement form: `measure - value = 0`. The only parameter is the value of the FUNCTION.
///
/// The reaction `-multiplier * row` is the force or torque that drives I along or about an axis of J. The equation is valid wherever the
/// measure is defined. Source: Adams Solver help, `state_motion`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Drive {
    /// Displacement that the MOTION prescribes.
    pub measure: RelativeCoordinate,
}

impl Constraint for Drive {
    fn count(&self) -> usize {
        1
    }

    fn parameter_count(&self) -> usize {
        1
    }

    fn equation_name(&self, _k: usize) -> &'static str {
        match self.measure {
            RelativeCoordinate::Translation(axis) => ["X", "Y", "Z"][axis],
            RelativeCoordinate::Angle(axis) => ["AX", "AY", "AZ"][axis],
            RelativeCoordinate::Body123(axis) => ["B1", "B2", "B3"][axis],
            RelativeCoordinate::Pinion => "Turn",
        }
    }

    fn uses_angles(&self) -> bool {
        self.measure.uses_angles()
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        multipliers: &[f64],
        out: &mut Equations,
    ) {
        let measured = self.measure.evaluate(motion, theta[0]);
        out.count = 1;
        out.residual[0] = measured.value - theta[0];
        out.jacobian[0] = measured.row;
        out.curvature = measured.curvature * multipliers[0];
        out.residual_by_parameter = -1.0;
        out.jacobian_by_parameter = Vec6::zeros();
    }
}
