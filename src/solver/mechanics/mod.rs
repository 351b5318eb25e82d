//! Poses, rotations, relative motion and wrenches; eigenvalues.
//!
//! nalgebra only. Knows no names, units or files. Frames live in names: `R_ji` turns components in I axes into components
//! in J axes, `p_ij_j` is the position of I from J resolved in J.
//!
//! Here and above, what a solution is made of takes sines, exponentials and powers from the crate `libm`: the C library differs from
//! system to system in last digits, and for large angles in all of them.

pub mod eigen;
mod pose;
mod relative_motion;
mod rotation;
#[cfg(test)]
pub(crate) mod testing;

pub use pose::Pose;
pub use relative_motion::RelativeMotion;
pub use rotation::projected_angles;
pub use rotation::skew;
pub use rotation::{euler313, exp, log, psi_theta_phi};
pub(crate) use rotation::{turning_rate, unwrap_near};

/// A vector in three dimensions.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3 by 3 matrix; for rotations the columns are the axes of the turned frame.
pub type Mat3 = nalgebra::Matrix3<f64>;
/// A pair of vectors: (translation, rotation) of a motion, (force, torque) of a wrench.
pub type Vec6 = nalgebra::Vector6<f64>;
/// A 6 by 6 matrix over such pairs.
pub type Mat6 = nalgebra::Matrix6<f64>;
