//! The SCREW joint. The module is independent of the CYLINDRICAL joint that usually accompanies it.

use super::{Constraint, Equations, RelativeCoordinate};
use crate::mechanics::{RelativeMotion, Vec6};

/// SCREW: `d.zj - PITCH / (2 pi) AZ = 0`, with d the vector from the J origin to the I origin. AZ is the rotation of I about zj, counted
/// over full turns. The thread is right-handed.
///
/// The joint has one equation; ADAMS decks combine it with a CYLINDRICAL joint. The parameter is PITCH, the translation per turn. The
/// equation is valid for any number of turns and undefined where xi lies along zj. Source: Adams Solver help, `state_joint`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Screw;

impl Constraint for Screw {
    fn count(&self) -> usize {
        1
    }

    fn parameter_count(&self) -> usize {
        1
    }

    fn equation_name(&self, _k: usize) -> &'static str {
        "D.Zj-Pitch*Az"
    }

    fn uses_angles(&self) -> bool {
        true
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        multipliers: &[f64],
        out: &mut Equations,
    ) {
        let per_radian = theta[0] / std::f64::consts::TAU;
        let turn = RelativeCoordinate::Angle(2).evaluate(motion, 0.0);
        out.count = 1;
        out.residual[0] = motion.p_ij_j.z - per_radian * turn.value;
        out.jacobian[0] = Vec6::ith(2, 1.0) - turn.row * per_radian;
        out.curvature = turn.curvature * (-per_radian * multipliers[0]);
        out.residual_by_parameter = -turn.value / std::f64::consts::TAU;
        out.jacobian_by_parameter = turn.row / -std::f64::consts::TAU;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::{Vec3, exp};

    /// A right-handed screw of pitch 5 advances 12.5 along zj in two and a half turns.
    #[test]
    fn a_screw_advances_by_its_pitch_per_turn() {
        let turn = 2.5 * std::f64::consts::TAU;
        let motion = RelativeMotion {
            p_ij_j: Vec3::new(0.0, 0.0, 12.5),
            R_ji: exp(&Vec3::new(0.0, 0.0, turn)),
            angles: Vec3::new(0.0, 0.0, turn),
        };
        let mut out = Equations::default();
        Screw.evaluate(&motion, &[5.0], &[1.0], &mut out);
        assert!(out.residual[0].abs() < 1e-13);
        assert!(out.curvature.column(2).norm() < 1e-15);
    }
}
