//! The joint primitives of JPRIM (Adams Solver help, `state_jprim`) as locked distances and scalar products.
//!
//! The frames are those of [`super::joint`]. The module is independent of the deck statement.

use super::Locks;

/// ATPOINT: d = 0.
pub(crate) const AT_POINT: Locks = Locks {
    distances: &[0, 1, 2],
    products: &[],
};
/// INLINE: d.xj = d.yj = 0; the origin of I stays on the z axis of J.
pub(crate) const INLINE: Locks = Locks {
    distances: &[0, 1],
    products: &[],
};
/// INPLANE: d.zj = 0; the origin of I stays in the xy plane of J.
pub(crate) const INPLANE: Locks = Locks {
    distances: &[2],
    products: &[],
};
/// ORIENTATION: zi.xj = zi.yj = xi.yj = 0; the axes stay parallel.
pub(crate) const ORIENTATION: Locks = Locks {
    distances: &[],
    products: &[(2, 0), (2, 1), (0, 1)],
};
/// PARALLEL_AXES: zi.xj = zi.yj = 0.
pub(crate) const PARALLEL_AXES: Locks = Locks {
    distances: &[],
    products: &[(2, 0), (2, 1)],
};
/// PERPENDICULAR: zi.zj = 0.
pub(crate) const PERPENDICULAR: Locks = Locks {
    distances: &[],
    products: &[(2, 2)],
};
