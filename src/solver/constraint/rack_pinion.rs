//! The RACKPIN joint. The module is independent of the joints that hold rack and pinion on their carrier.

use super::{Constraint, Equations, RelativeCoordinate};
use crate::mechanics::{RelativeMotion, Vec6};

/// Sign of the rack motion. With +1 and a positive PD, the rack moves along +zj when the pinion turns positively about zi. The rack then
/// rolls without slip on the -yi side of the pinion. The help does not state the sign; the only public deck with this joint draws its rack
/// on that side (grammar/NOTES.md).
const SENSE: f64 = 1.0;

/// RACKPIN: I is on the pinion, which turns about zi. J is on the rack, which slides along zj. At zero rotation, xi lies along zj.
///
/// The equation is `-d.zj - SENSE PD / 2 phi = 0`. Here d is the vector from the J origin to the I origin, and phi is the rotation of I
/// about zi, measured from the position with xi along zj. The rack carries J, so its displacement relative to I is `-d`, and it advances by
/// the pitch radius times phi. Full turns are counted by choosing the phi nearest to the value that follows from the rack position. This is
/// the only equation; other joints keep the axes perpendicular. The parameter is PD, the signed pitch diameter. The equation is valid as
/// long as zj does not lie along the pinion axis zi. Source: Adams Solver help, `state_joint`, `constraint_mod_joi_rac`; for the sign see
/// `SENSE`.
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
        // If the pitch radius is zero, the rack position does not determine the rotation.
        let near = if radius == 0.0 { 0.0 } else { advance / radius };
        let turn = RelativeCoordinate::Pinion.evaluate(motion, near);
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

    /// With xi along zj and the rack on the -yi side, the rack moves like the contact point of the pinion: omega x r.
    #[test]
    fn the_rack_rolls_without_slip() {
        let (radius, turn) = (10.0, 1e-3);
        // Columns xi, yi, zi in axes of J: xi = zj, yi = xj, zi = yj.
        let rest = Mat3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0);
        let touching = rest * Vec3::new(0.0, -radius, 0.0);
        let moved = turn * (rest * Vec3::z()).cross(&touching);
        assert!(moved.z > 0.0 && moved.x == 0.0 && moved.y == 0.0);
        let motion = RelativeMotion {
            // Position of I relative to J, after the rack has advanced.
            p_ij_j: -touching - moved,
            R_ji: rest * exp(&Vec3::new(0.0, 0.0, turn)),
            angles: Vec3::zeros(),
        };
        let mut out = Equations::default();
        RackPinion.evaluate(&motion, &[2.0 * radius], &[1.0], &mut out);
        assert!(out.residual[0].abs() < 1e-12, "{}", out.residual[0]);
    }

    /// A pinion of pitch diameter 20 that turns by 7.5 rad, more than a full turn, moves the rack by 75.
    #[test]
    fn the_rack_advances_by_radius_times_turn() {
        // At zero rotation, xi lies along zj and zi along yj.
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
        // Only the rotation about zi = yj and the travel contribute.
        assert!((out.jacobian[0] - Vec6::new(0.0, 0.0, -1.0, 0.0, -10.0, 0.0)).norm() < 1e-12);
    }
}
