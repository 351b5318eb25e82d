use super::{Mat3, Vec3, exp};

/// Position and orientation of a frame: `x_base = p + R * x_local`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Pose {
    /// Origin of the frame, in axes of the base frame.
    pub p: Vec3,
    /// Rotation matrix; its columns are the axes of the frame, resolved in the base frame.
    pub R: Mat3,
}

impl Pose {
    /// Returns the pose of the base frame itself.
    pub fn identity() -> Self {
        Self {
            p: Vec3::zeros(),
            R: Mat3::identity(),
        }
    }

    /// Returns the base coordinates of a point given in this frame.
    pub fn point(&self, x_local: &Vec3) -> Vec3 {
        self.p + self.R * x_local
    }

    #[must_use]
    /// Composes two poses: `other` is relative to this frame, and the result is relative to the base frame (`self * other`).
    pub fn compose(&self, other: &Self) -> Self {
        Self {
            p: self.point(&other.p),
            R: self.R * other.R,
        }
    }

    #[must_use]
    /// Returns the pose after one unit of time of a steady screw motion. The origin starts with velocity `v`, and the frame rotates with
    /// constant angular velocity `w`, both in base axes. This is the exponential map of a twist: Murray, Li and Sastry, A Mathematical
    /// Introduction to Robotic Manipulation, equation 2.36.
    pub fn displaced(&self, v: &Vec3, w: &Vec3) -> Self {
        let angle = w.norm();
        let (once, twice) = if angle > 1e-6 {
            let square = angle * angle;
            let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
            ((1.0 - cosine) / square, (angle - sine) / (square * angle))
        } else {
            (0.5, 1.0 / 6.0)
        };
        let turned = w.cross(v);
        Self {
            p: self.p + v + once * turned + twice * w.cross(&turned),
            R: exp(w) * self.R,
        }
    }

    #[must_use]
    /// Returns the pose of the base frame seen from this frame.
    pub fn inverse(&self) -> Self {
        Self {
            p: -(self.R.transpose() * self.p),
            R: self.R.transpose(),
        }
    }
}
