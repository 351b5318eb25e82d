//! Poses, rotations, relative motion and eigenvalues.
//!
//! The module is independent of names, units and files. The names of variables state their frames: `R_ji` turns components in I axes into
//! components in J axes, and `p_ij_j` is the position of I relative to J, resolved in J axes.
//!
//! In this module and in the modules that build on it, all sines, exponentials and powers that affect a solution are computed by the crate
//! `libm`. The C libraries of different systems give results that differ in the last digits, and for large angles in all digits.

mod columns;
pub mod eigen;
mod francis;
mod nan;
mod pose;
mod relative_motion;
mod rotation;
mod singular;
#[cfg(test)]
pub(crate) mod testing;

pub use columns::dot;
pub(crate) use nan::{exceeds, larger};
pub use pose::Pose;
pub use relative_motion::RelativeMotion;
pub use rotation::projected_angles;
pub use rotation::skew;
pub use rotation::{euler313, exp, log, psi_theta_phi};
pub(crate) use rotation::{turning_rate, unwrap_near};

/// A vector in three dimensions.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3 by 3 matrix. If it is a rotation matrix, its columns are the axes of the rotated frame.
pub type Mat3 = nalgebra::Matrix3<f64>;
/// A pair of vectors: (translation, rotation) of a motion, or (force, torque) of a wrench.
pub type Vec6 = nalgebra::Vector6<f64>;
/// A 6 by 6 matrix that acts on vectors like [`Vec6`].
pub type Mat6 = nalgebra::Matrix6<f64>;
