//! The deflection of bushing-like elements. Knows no stiffness.

use super::Degenerate;
use crate::mechanics::{Mat3, RelativeMotion, Vec3, Vec6};

/// The six deflections (x, y, z, AX, AY, AZ) of a bushing-like element and what their angles change with.
///
/// x, y, z = `p_ij_j`; the angles are those of the functions AX, AY, AZ (`cfunc_ax`) and count turns. Their row about axis n of J, with v
/// the turning I axis and w = v without its n component, is `e_n - v_n w / (w . w)`. Small-angle meaning is lost beyond about
/// 10 degrees of the other two angles; at 90 degrees an angle is undefined.
pub(super) struct Deflection {
    pub translation: Vec3,
    pub angles: Vec3,
    /// Row n: derivative of angle n by `dtheta` in J axes.
    pub angle_rows: Mat3,
}

/// Below this square of the sine of the remaining direction an angle has no value left.
const VANISHING: f64 = 1e-20;

impl Deflection {
    pub(super) fn of(motion: &RelativeMotion) -> Result<Self, Degenerate> {
        let R = &motion.R_ji;
        // zi turns about xj and yj, xi about zj.
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

    /// (x, y, z, AX, AY, AZ).
    pub(super) fn coordinates(&self) -> Vec6 {
        Vec6::from_fn(|k, _| self.component(k))
    }

    /// Component 0..6 of (x, y, z, AX, AY, AZ).
    pub(super) fn component(&self, k: usize) -> f64 {
        if k < 3 {
            self.translation[k]
        } else {
            self.angles[k - 3]
        }
    }
}
