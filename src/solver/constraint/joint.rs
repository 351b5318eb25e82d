//! The lower-pair joints of JOINT (Adams Solver help, `state_joint`) as locked distances and scalar products.
//!
//! Frames: d is the vector from the J origin to the I origin; xi, yi, zi are the axes of I, and xj, yj, zj are the axes of J. Pitch, drive
//! and friction are defined in other files.

use super::Locks;

const Z_PARALLEL: &[(usize, usize)] = &[(2, 0), (2, 1)];
const AXES_PARALLEL: &[(usize, usize)] = &[(2, 0), (2, 1), (0, 1)];

/// SPHERICAL: d = 0.
pub(crate) const SPHERICAL: Locks = Locks {
    distances: &[0, 1, 2],
    products: &[],
};
/// REVOLUTE: d = 0, zi.xj = zi.yj = 0.
pub(crate) const REVOLUTE: Locks = Locks {
    distances: &[0, 1, 2],
    products: Z_PARALLEL,
};
/// TRANSLATIONAL: d.xj = d.yj = 0, zi.xj = zi.yj = xi.yj = 0.
pub(crate) const TRANSLATIONAL: Locks = Locks {
    distances: &[0, 1],
    products: AXES_PARALLEL,
};
/// CYLINDRICAL: d.xj = d.yj = 0, zi.xj = zi.yj = 0.
pub(crate) const CYLINDRICAL: Locks = Locks {
    distances: &[0, 1],
    products: Z_PARALLEL,
};
/// PLANAR: d.zj = 0, zi.xj = zi.yj = 0.
pub(crate) const PLANAR: Locks = Locks {
    distances: &[2],
    products: Z_PARALLEL,
};
/// FIXED: d = 0, zi.xj = zi.yj = xi.yj = 0.
pub(crate) const FIXED: Locks = Locks {
    distances: &[0, 1, 2],
    products: AXES_PARALLEL,
};
/// HOOKE: d = 0, xi.yj = 0. The shafts lie along zi and zj, the pins of the cross along xi and yj.
pub(crate) const HOOKE: Locks = Locks {
    distances: &[0, 1, 2],
    products: &[(0, 1)],
};
/// UNIVERSAL: d = 0, zi.zj = 0. The pins of the cross lie along zi and zj.
pub(crate) const UNIVERSAL: Locks = Locks {
    distances: &[0, 1, 2],
    products: &[(2, 2)],
};
