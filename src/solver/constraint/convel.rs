//! Constraint equations of the CONVEL (constant-velocity) joint. The module contains no torque balance.

use super::locks::add_product;
use super::{Constraint, Equations};
use crate::mechanics::{Mat3, RelativeMotion, Vec6};

/// CONVEL: constant-velocity joint with its shafts along zi and zj.
///
/// With d the vector from the J origin to the I origin, the equations are d = 0 and one product equation. The product equation is `xi.yj -
/// yi.xj = 0` for co-directed z axes, and `xi.yj + yi.xj = 0` for opposed z axes (both pointing away from the joint). With the wrong sign,
/// the product equation holds for every twist and constrains nothing. [`Convel::for_design`] therefore selects the sign once, from the
/// design position. The joint is undefined when the shafts fold to 90 degrees. Source: Adams Solver help, `state_joint`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Convel {
    /// The z axes are co-directed: zi.zj >= 0 in the design position.
    CoDirected,
    /// The z axes are opposed: zi.zj < 0 in the design position.
    Opposed,
}

impl Convel {
    /// Returns the variant that matches the relative motion in the design position.
    pub(crate) fn for_design(motion: &RelativeMotion) -> Self {
        if motion.R_ji[(2, 2)] >= 0.0 {
            Self::CoDirected
        } else {
            Self::Opposed
        }
    }
}

impl Constraint for Convel {
    fn count(&self) -> usize {
        4
    }

    fn equation_name(&self, k: usize) -> &'static str {
        match (self, k) {
            (_, 0) => "D.Xj",
            (_, 1) => "D.Yj",
            (_, 2) => "D.Zj",
            (Self::CoDirected, _) => "Xi.Yj-Yi.Xj",
            (Self::Opposed, _) => "Xi.Yj+Yi.Xj",
        }
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        _theta: &[f64],
        multipliers: &[f64],
        out: &mut Equations,
    ) {
        let sign = match self {
            Self::CoDirected => -1.0,
            Self::Opposed => 1.0,
        };
        out.count = 4;
        out.curvature = Mat3::zeros();
        for axis in 0..3 {
            out.residual[axis] = motion.p_ij_j[axis];
            out.jacobian[axis] = Vec6::ith(axis, 1.0);
        }
        out.residual[3] = motion.R_ji[(1, 0)] + sign * motion.R_ji[(0, 1)];
        out.jacobian[3] = Vec6::zeros();
        add_product(motion, 0, 1, 1.0, multipliers[3], 3, out);
        add_product(motion, 1, 0, sign, multipliers[3], 3, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::{Vec3, exp};

    /// Returns the relative motion of aligned markers, twisted by `angle` about zj. Their z axes are co-directed or, if `opposed`, opposed.
    fn twisted(angle: f64, opposed: bool) -> RelativeMotion {
        let design = if opposed {
            exp(&Vec3::new(std::f64::consts::PI, 0.0, 0.0))
        } else {
            Mat3::identity()
        };
        RelativeMotion {
            p_ij_j: Vec3::zeros(),
            R_ji: exp(&Vec3::new(0.0, 0.0, angle)) * design,
            angles: Vec3::zeros(),
        }
    }

    #[test]
    fn the_right_sense_resists_a_twist_and_the_wrong_one_does_not() {
        for opposed in [false, true] {
            let right = Convel::for_design(&twisted(0.0, opposed));
            let wrong = match right {
                Convel::CoDirected => Convel::Opposed,
                Convel::Opposed => Convel::CoDirected,
            };
            let mut out = Equations::default();
            for angle in [-2.0, -0.4, 0.3, 1.5] {
                let motion = twisted(angle, opposed);
                right.evaluate(&motion, &[], &[0.0; 4], &mut out);
                // The residual is 2 sin(angle), up to its sign.
                assert!((out.residual[3].abs() - 2.0 * angle.sin().abs()).abs() < 1e-14);
                wrong.evaluate(&motion, &[], &[0.0; 4], &mut out);
                assert!(out.residual[3].abs() < 1e-14);
                assert!(out.jacobian[3][5].abs() < 1e-14);
            }
        }
    }

    /// Constant velocity: with bent shafts, turning both shafts by the same angle still satisfies the equations. A Hooke joint would
    /// violate its equation in the same motion.
    #[test]
    fn both_shafts_turn_alike_when_bent() {
        let mut out = Equations::default();
        let bend = exp(&Vec3::new(0.0, 0.5, 0.0));
        for turn in [0.0, 0.4, 1.1, 2.9] {
            let spin = exp(&Vec3::new(0.0, 0.0, turn));
            let motion = RelativeMotion {
                p_ij_j: Vec3::zeros(),
                // J turns by `turn` about its own z, I about its own: R_ji = Rz(-turn) bend Rz(turn).
                R_ji: spin.transpose() * bend * spin,
                angles: Vec3::zeros(),
            };
            Convel::CoDirected.evaluate(&motion, &[], &[0.0; 4], &mut out);
            assert!(out.residual[3].abs() < 1e-14, "{turn}");
        }
    }
}
