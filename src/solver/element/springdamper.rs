//! The elastic laws of the two SPRINGDAMPER types. The damping is in [`super::damping`]; in statics all velocities are zero.

use super::line::Line;
use super::{Degenerate, Law, LawEntry, Wrench};
use crate::mechanics::{Mat6, RelativeMotion, Vec6};

pub(super) const LAWS: &[LawEntry] = &[
    LawEntry {
        name: "translational_spring_damper",
        law: &TranslationalSpring,
    },
    LawEntry {
        name: "rotational_spring_damper",
        law: &RotationalSpring,
    },
];

/// SPRINGDAMPER, TRANSLATIONAL: a spring along the line between the two origins.
///
/// Law, with r = |d| and n = d / r: `F = f n` on I at the I origin, with `f = -K (r - LENGTH) + FORCE`; positive f repels. The derivative
/// includes the rotation of the line: `dF/dd = -K n n' + f / r (1 - n n')`. No torque acts on either marker. Parameters: K, LENGTH, FORCE.
/// Validity: r > 0; at r = 0 ADAMS stops, and this law returns an error. Source: Adams Solver help, `state_springdamper`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct TranslationalSpring;

impl Law for TranslationalSpring {
    fn parameter_count(&self) -> usize {
        3
    }

    fn uses_angles(&self) -> bool {
        false
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        with_parameters: bool,
        out: &mut Wrench,
    ) -> Result<(), Degenerate> {
        let line = Line::of(motion)?;
        let (k, length, preload) = (theta[0], theta[1], theta[2]);
        let stretch = line.length - length;
        line.force(-k * stretch + preload, -k, out);
        if with_parameters {
            let n = line.unit_wrench();
            let columns = out.parameter_columns(3);
            columns[0] = -stretch * n;
            columns[1] = k * n;
            columns[2] = n;
        }
        Ok(())
    }

    #[cfg(test)]
    fn energy(&self, motion: &RelativeMotion, theta: &[f64]) -> Option<f64> {
        let stretch = motion.p_ij_j.norm() - theta[1];
        Some(0.5 * theta[0] * stretch * stretch - theta[2] * stretch)
    }
}

/// SPRINGDAMPER, ROTATIONAL: a torsion spring about the z axis of J.
///
/// Law: `T = (-KT (theta - ANGLE) + TORQUE) zj` on I. theta is the rotation of xi about zj (AZ, counted over full turns). Parameters: KT
/// (per radian), ANGLE, TORQUE. Validity: zi parallel to zj, which ADAMS requires but does not enforce; the angle is undefined where xi
/// lies along zj. Source: Adams Solver help, `state_springdamper`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct RotationalSpring;

impl Law for RotationalSpring {
    fn parameter_count(&self) -> usize {
        3
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        with_parameters: bool,
        out: &mut Wrench,
    ) -> Result<(), Degenerate> {
        let xi = motion.R_ji.column(0);
        let s = xi[0] * xi[0] + xi[1] * xi[1];
        if s < 1e-20 {
            return Err(Degenerate::UndefinedAngle { axis: 2 });
        }
        let (kt, angle, preload) = (theta[0], theta[1], theta[2]);
        let turn = motion.angles.z - angle;
        out.value = Vec6::ith(5, -kt * turn + preload);
        out.by_motion = Mat6::zeros();
        out.by_motion[(5, 3)] = kt * xi[0] * xi[2] / s;
        out.by_motion[(5, 4)] = kt * xi[1] * xi[2] / s;
        out.by_motion[(5, 5)] = -kt;
        if with_parameters {
            let columns = out.parameter_columns(3);
            columns[0][5] = -turn;
            columns[1][5] = kt;
            columns[2][5] = 1.0;
        }
        Ok(())
    }
}
