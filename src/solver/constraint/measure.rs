//! Displacements between two markers with first and second derivatives. The module contains no constraint equations.

use super::angle::{about_i, about_j};
use crate::mechanics::{Mat3, RelativeMotion, Vec3, Vec6, unwrap_near};

/// Scalar displacement between two markers, as prescribed by a MOTION or combined by a COUPLER or GEAR.
///
/// Frames: I relative to J, right-handed; angles in radians. Sources: Adams Solver help, `state_joint` (displacement of a joint),
/// `state_motion`, `cfunc_az`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum RelativeCoordinate {
    /// Component of `p_ij_j` along the x, y or z axis of J (0, 1, 2).
    Translation(usize),
    /// Projected angle AX, AY or AZ (0, 1, 2), counted over full turns. AZ is the rotation of a joint about zj.
    Angle(usize),
    /// Body-fixed 1-2-3 angle b1, b2 or b3 (0, 1, 2) of I in J: `R_ji = Rx(b1) Ry(b2) Rz(b3)`. b1 counts full turns, and b2 lies in [-pi/2,
    /// pi/2]. b3 is shifted by full turns to the value nearest to a given angle. Undefined at b2 = +-pi/2.
    Body123(usize),
    /// Rotation of I about zi, measured from the position with xi along zj (RACKPIN). Shifted by full turns to the value nearest to a given
    /// angle.
    Pinion,
}

/// Value of a relative coordinate with its derivatives with respect to the relative motion.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct RelativeCoordinateValue {
    /// Displacement: a length, or an angle in radians.
    pub value: f64,
    /// Derivative with respect to (change of `p_ij_j`, `dtheta` in J axes).
    pub row: Vec6,
    /// Derivative of the rotational half of `row`, taken as a column, with respect to `dtheta`. All other second derivatives are zero.
    pub curvature: Mat3,
}

impl RelativeCoordinate {
    /// Returns whether the coordinate reads `RelativeMotion::angles`.
    pub(crate) fn uses_angles(self) -> bool {
        matches!(self, Self::Angle(_) | Self::Body123(0))
    }

    /// Evaluates the coordinate for a relative motion. `Body123(2)` and `Pinion` are shifted by full turns to the value nearest to `near`.
    pub(crate) fn evaluate(self, motion: &RelativeMotion, near: f64) -> RelativeCoordinateValue {
        let R = &motion.R_ji;
        let turning = |value: f64, (g, curvature): (Vec3, Mat3)| RelativeCoordinateValue {
            value,
            row: Vec6::new(0.0, 0.0, 0.0, g.x, g.y, g.z),
            curvature,
        };
        match self {
            Self::Translation(axis) => RelativeCoordinateValue {
                value: motion.p_ij_j[axis],
                row: Vec6::ith(axis, 1.0),
                curvature: Mat3::zeros(),
            },
            Self::Angle(n) => {
                let v = R.column(if n == 2 { 0 } else { 2 }).into_owned();
                turning(motion.angles[n], about_j(&v, n))
            }
            // zi has the components (sin b2, -sin b1 cos b2, cos b1 cos b2), hence b1 equals AX.
            Self::Body123(0) => turning(motion.angles.x, about_j(&R.column(2).into_owned(), 0)),
            Self::Body123(1) => {
                // sin b2 = zi . xj, db2 = g / cos b2 with g = zi x xj, and d(1 / cos b2) = sin b2 / cos^3 b2 g.
                let zi = R.column(2);
                let (s, c) = (zi[0], libm::hypot(R[(0, 0)], R[(0, 1)]));
                let g = Vec3::new(0.0, zi[2], -zi[1]);
                let mut by_dtheta = Mat3::from_diagonal_element(-s);
                for a in 0..3 {
                    by_dtheta[(a, 0)] += zi[a];
                }
                turning(
                    libm::atan2(s, c),
                    (g / c, by_dtheta / c + g * g.transpose() * (s / (c * c * c))),
                )
            }
            // xj has the components (cos b2 cos b3, -cos b2 sin b3, sin b2) in I.
            Self::Body123(_) => turning(
                unwrap_near(libm::atan2(-R[(0, 1)], R[(0, 0)]), near),
                about_i(R, 0, 2),
            ),
            Self::Pinion => turning(
                unwrap_near(libm::atan2(-R[(2, 1)], R[(2, 0)]), near),
                about_i(R, 2, 2),
            ),
        }
    }
}
