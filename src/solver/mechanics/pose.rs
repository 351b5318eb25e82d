use super::{Mat3, Vec3, exp};

/// Where a frame is: `x_base = p + R * x_local`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Pose {
    /// Origin, in base axes.
    pub p: Vec3,
    /// Rotation matrix; its columns are the frame's axes in the base.
    pub R: Mat3,
}

impl Pose {
    /// The base frame itself.
    pub fn identity() -> Self {
        Self {
            p: Vec3::zeros(),
            R: Mat3::identity(),
        }
    }

    /// A point of the frame, in base coordinates.
    pub fn point(&self, x_local: &Vec3) -> Vec3 {
        self.p + self.R * x_local
    }

    #[must_use]
    /// `self * other`: the pose of a frame given in this frame.
    pub fn compose(&self, other: &Self) -> Self {
        Self {
            p: self.point(&other.p),
            R: self.R * other.R,
        }
    }

    #[must_use]
    /// Where the frame is after a unit of time in which it moves steadily: its origin with velocity `v` at first, all of it with angular
    /// velocity `w`, both in base axes. The exponential map of a twist: Murray, Li and Sastry, A Mathematical Introduction to Robotic
    /// Manipulation, equation 2.36.
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
    /// The base seen from this frame.
    pub fn inverse(&self) -> Self {
        Self {
            p: -(self.R.transpose() * self.p),
            R: self.R.transpose(),
        }
    }
}
