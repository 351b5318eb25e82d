//! Forces along the line of two origins, with the turning of the line. Knows no law for the magnitude.

use super::{Degenerate, Wrench};
use crate::mechanics::{Mat3, Mat6, RelativeMotion, Vec3, Vec6};

/// The line from the origin of J to the origin of I: direction in J axes and length.
pub(super) struct Line {
    pub direction: Vec3,
    pub length: f64,
}

/// Lengths below this many length units have no direction.
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

    /// Unit force along the line, pushing I away from J.
    pub(super) fn unit_wrench(&self) -> Vec6 {
        let n = &self.direction;
        Vec6::new(n.x, n.y, n.z, 0.0, 0.0, 0.0)
    }

    /// F = f n with f depending on the length by `slope`: dF/dp = slope n n' + f / r (1 - n n').
    pub(super) fn force(&self, f: f64, slope: f64, out: &mut Wrench) {
        let n = &self.direction;
        out.value = self.unit_wrench() * f;
        let across = f / self.length;
        let by_p = Mat3::from_diagonal_element(across) + n * n.transpose() * (slope - across);
        out.by_motion = Mat6::zeros();
        out.by_motion.fixed_view_mut::<3, 3>(0, 0).copy_from(&by_p);
    }
}
