//! The RACKPIN joint. Knows nothing of the joints that hold rack and pinion on their carrier.

use super::{Constraint, Equations, Measure};
use crate::mechanics::{RelativeMotion, Vec6};

/// The rack moves along +zj when the pinion turns positively about zi and PD is positive: it rolls without slip on the side of -yi.
/// No page of the help states it; the one public deck that uses the joint draws its rack there (grammar/NOTES.md).
const SENSE: f64 = 1.0;

/// RACKPIN: I on the pinion, turning about zi, J on the rack, sliding along zj; xi along zj at rest.
///
/// Equation: `-d.zj - SENSE PD / 2 phi = 0`: the rack (J, whose displacement relative to I is `-d`) advances by the pitch radius
/// times the rotation phi of I about zi, measured from where xi points along zj. Turns are counted by taking phi nearest to
/// what the rack's place asks for. One equation; other joints hold the axes perpendicular. Parameter: PD, the pitch diameter,
/// signed. Valid as long as xi does not lie along the pinion axis. Source: Adams Solver help, `state_joint`,
/// `constraint_mod_joi_rac`; the sign as `SENSE` says.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct RackPinion;

impl Constraint for RackPinion {
    fn count(&self) -> usize {
        1
    }

    fn parameter_count(&self) -> usize {
        1
    }

    fn equation_name(&self, _k: usize) -> &'static str {
        "-D.Zj-Radius*Turn"
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        multipliers: &[f64],
        out: &mut Equations,
    ) {
        let radius = SENSE * 0.5 * theta[0];
        let advance = -motion.p_ij_j.z;
        // A rack without radius asks for no turn.
        let near = if radius == 0.0 { 0.0 } else { advance / radius };
        let turn = Measure::Pinion.evaluate(motion, near);
        out.count = 1;
        out.residual[0] = advance - radius * turn.value;
        out.jacobian[0] = Vec6::ith(2, -1.0) - turn.row * radius;
        out.curvature = turn.curvature * (-radius * multipliers[0]);
        out.residual_by_parameter = -0.5 * SENSE * turn.value;
        out.jacobian_by_parameter = turn.row * (-0.5 * SENSE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::{Mat3, Vec3, exp};

    /// xi along zj, the rack on the side of -yi: it moves as the point of the pinion that touches it, omega x r.
    #[test]
    fn the_rack_rolls_without_slip() {
        let (radius, turn) = (10.0, 1e-3);
        // Columns xi, yi, zi in axes of J: xi = zj, yi = xj, zi = yj.
        let rest = Mat3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0);
        let touching = rest * Vec3::new(0.0, -radius, 0.0);
        let moved = turn * (rest * Vec3::z()).cross(&touching);
        assert!(moved.z > 0.0 && moved.x == 0.0 && moved.y == 0.0);
        let motion = RelativeMotion {
            // I from J: the rack has gone on.
            p_ij_j: -touching - moved,
            R_ji: rest * exp(&Vec3::new(0.0, 0.0, turn)),
            angles: Vec3::zeros(),
        };
        let mut out = Equations::default();
        RackPinion.evaluate(&motion, &[2.0 * radius], &[1.0], &mut out);
        assert!(out.residual[0].abs() < 1e-12, "{}", out.residual[0]);
    }

    /// A pinion of pitch diameter 20 that turns 7.5 rad moves the rack by 75, more than a turn away.
    #[test]
    fn the_rack_advances_by_radius_times_turn() {
        // At rest xi along zj, zi along yj.
        let rest = Mat3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0);
        let turn = 7.5;
        let motion = RelativeMotion {
            p_ij_j: Vec3::new(3.0, 0.0, -75.0),
            R_ji: rest * exp(&Vec3::new(0.0, 0.0, turn)),
            angles: Vec3::zeros(),
        };
        let mut out = Equations::default();
        RackPinion.evaluate(&motion, &[20.0], &[1.0], &mut out);
        assert!(out.residual[0].abs() < 1e-12, "{}", out.residual[0]);
        // Only the turn about zi = yj and the travel count.
        assert!((out.jacobian[0] - Vec6::new(0.0, 0.0, -1.0, 0.0, -10.0, 0.0)).norm() < 1e-12);
    }
}
