use super::{Mat3, Vec3};

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
    /// The base seen from this frame.
    pub(crate) fn inverse(&self) -> Self {
        Self {
            p: -(self.R.transpose() * self.p),
            R: self.R.transpose(),
        }
    }
}
