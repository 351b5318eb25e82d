//! Angles between two markers: their first and second derivatives with respect to rotations. The constraints use them.

use crate::mechanics::{Mat3, Vec3, skew};

/// Returns the Jacobian row `e_n - v_n w / (w . w)` of the angle of a vector v about axis n, and the derivative of that row with respect to
/// v. Here w is v without its component n.
fn row(v: &Vec3, n: usize) -> (Vec3, Mat3) {
    let mut w = *v;
    w[n] = 0.0;
    let s = w.norm_squared();
    let e = Vec3::ith(n, 1.0);
    let mut flat = Mat3::identity();
    flat[(n, n)] = 0.0;
    let by_v =
        (w * e.transpose() + flat * v[n]) * (-1.0 / s) + w * w.transpose() * (2.0 * v[n] / (s * s));
    (e - w * (v[n] / s), by_v)
}

/// Returns the Jacobian row of the angle that an axis v of I (in J axes) makes about axis n of J. The second value is the derivative of
/// this row with respect to `dtheta`, a small rotation of I in J axes.
///
/// With `dv = dtheta x v`, the row is `g = e_n - v_n w / (w . w)` and `dg = (dg/dv) (dtheta x v)`.
pub(super) fn about_j(v: &Vec3, n: usize) -> (Vec3, Mat3) {
    let (g, by_v) = row(v, n);
    (g, -by_v * skew(v))
}

/// Returns the Jacobian row of the angle by which I has turned about its own axis n away from axis m of J. The second value is the
/// derivative of this row with respect to `dtheta`, a small rotation of I. Both are in J axes.
///
/// With u = e_m expressed in I axes, the angle is minus the angle of u about n. With `du = skew(u) R' dtheta`, the row is `g = R row(u)`,
/// hence `dg = dtheta x g + R (drow/du) skew(u) R' dtheta`.
pub(super) fn about_i(R_ji: &Mat3, m: usize, n: usize) -> (Vec3, Mat3) {
    let u: Vec3 = R_ji.row(m).transpose();
    let (row, by_u) = row(&u, n);
    let g = R_ji * row;
    (g, -skew(&g) + R_ji * by_u * skew(&u) * R_ji.transpose())
}
