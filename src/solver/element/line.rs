//! Forces along the line between two origins, with the derivative due to the rotation of the line. The module is independent of the law of
//! the magnitude.

use super::{Degenerate, Wrench};
use crate::mechanics::{Mat3, Mat6, RelativeMotion, Vec3, Vec6};

/// Line from the origin of J to the origin of I: its direction in J axes and its length.
pub(super) struct Line {
    pub direction: Vec3,
    pub length: f64,
}

/// Largest length, in length units of the model, at which a line counts as having no direction.
const ZERO_LENGTH: f64 = 1e-12;

impl Line {
    pub(super) fn of(motion: &RelativeMotion) -> Result<Self, Degenerate> {
        let length = motion.p_ij_j.norm();
        if length.is_nan() || length <= ZERO_LENGTH {
            return Err(Degenerate::ZeroLengthLine);
        }
        Ok(Self {
            direction: motion.p_ij_j / length,
            length,
        })
    }

    /// Returns the wrench of a unit force along the line, pushing I away from J.
    pub(super) fn unit_wrench(&self) -> Vec6 {
        let n = &self.direction;
        Vec6::new(n.x, n.y, n.z, 0.0, 0.0, 0.0)
    }

    /// Sets `out` to the force F = f n and its derivative dF/dp = slope n n' + f / r (1 - n n'). `slope` is the derivative of f with
    /// respect to the length.
    pub(super) fn force(&self, f: f64, slope: f64, out: &mut Wrench) {
        let n = &self.direction;
        out.value = self.unit_wrench() * f;
        let across = f / self.length;
        let by_p = Mat3::from_diagonal_element(across) + n * n.transpose() * (slope - across);
        out.by_motion = Mat6::zeros();
        out.by_motion.fixed_view_mut::<3, 3>(0, 0).copy_from(&by_p);
    }
}
