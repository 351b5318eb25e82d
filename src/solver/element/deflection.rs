//! Deflection of bushing-like elements. The module contains no stiffness.

use super::Degenerate;
use crate::mechanics::{Mat3, RelativeMotion, Vec3, Vec6};

/// The six deflections (x, y, z, AX, AY, AZ) of a bushing-like element and the derivatives of the angles.
///
/// x, y, z equal `p_ij_j`. The angles equal the functions AX, AY, AZ (`cfunc_ax`) and count full turns. The Jacobian row of the angle about
/// axis n of J is `e_n - v_n w / (w . w)`. Here v is the axis of I whose rotation defines the angle, and w is v without its n component. An
/// angle loses its small-angle meaning when the other two exceed about 10 degrees, and it is undefined when another angle reaches 90
/// degrees.
pub(super) struct Deflection {
    pub translation: Vec3,
    pub angles: Vec3,
    /// Row n is the derivative of angle n with respect to `dtheta` in J axes.
    pub angle_rows: Mat3,
}

/// Threshold for the squared length of an axis projected onto the plane of an angle. Below this threshold, the angle is undefined.
const VANISHING: f64 = 1e-20;

impl Deflection {
    pub(super) fn of(motion: &RelativeMotion) -> Result<Self, Degenerate> {
        let R = &motion.R_ji;
        // The direction of zi gives the angles about xj and yj; the direction of xi gives the angle about zj.
        for (axis, v) in [(0, R.column(2)), (1, R.column(2)), (2, R.column(0))] {
            let (a, b) = (v[(axis + 1) % 3], v[(axis + 2) % 3]);
            if a * a + b * b < VANISHING {
                return Err(Degenerate::UndefinedAngle { axis });
            }
        }
        Ok(Self {
            translation: motion.p_ij_j,
            angles: motion.angles,
            angle_rows: motion.angle_rows(),
        })
    }

    /// Returns (x, y, z, AX, AY, AZ).
    pub(super) fn coordinates(&self) -> Vec6 {
        Vec6::from_fn(|k, _| self.component(k))
    }

    /// Returns component `k` (0..6) of (x, y, z, AX, AY, AZ).
    pub(super) fn component(&self, k: usize) -> f64 {
        if k < 3 {
            self.translation[k]
        } else {
            self.angles[k - 3]
        }
    }
}
