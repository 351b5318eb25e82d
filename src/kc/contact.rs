//! Contact point of a wheel with the road, and the law of the rig's tyre. Source: guide page `kc`, sections "Geometry" and "The tests".
//!
//! o is the unit spin axis, n the upward unit normal of the road, P the wheel centre.

use super::Tyre;
use admire_solver::mechanics::Vec3;

/// Returns w, the unit projection of `-n` into the wheel plane. It points from the wheel centre to the contact point.
fn down(o: &Vec3, normal: &Vec3) -> Vec3 {
    (o * normal.dot(o) - normal).normalize()
}

/// Returns the contact point `C = P + r w`, the lowest point of the wheel within its own plane; `r` is the loaded radius.
pub(crate) fn contact_point(centre: &Vec3, o: &Vec3, normal: &Vec3, r: f64) -> Vec3 {
    centre + down(o, normal) * r
}

/// Returns the lever `d = min(r, R0) w` from the wheel centre to the point where road forces act. A tyre that pulls (r > R0) keeps the
/// lever R0.
pub(crate) fn lever(o: &Vec3, normal: &Vec3, r: f64, tyre: &Tyre) -> Vec3 {
    down(o, normal) * r.min(tyre.radius)
}

/// Returns the loaded radius r, the distance from the wheel centre along w to the road. The tyre's law is
/// `Fn = Kt (R0 - r) cos(gamma)` with `cos(gamma) = -w . n`, also for negative loads. Without a stiffness the tyre is rigid.
pub(crate) fn loaded_radius(tyre: &Tyre, normal_force: f64, o: &Vec3, normal: &Vec3) -> f64 {
    let tilt = -down(o, normal).dot(normal);
    tyre.radius - tyre.stiffness.map_or(0.0, |k| normal_force / (k * tilt))
}

/// Returns the lateral distance between the contact points.
pub fn total_track(left: &Vec3, right: &Vec3) -> f64 {
    right.y - left.y
}

/// Returns the roll angle `atan((zL - zR) / distance)`, in radians, from the heights of two points and their lateral distance. It is
/// positive with the left point up relative to the body.
pub fn roll_angle(left: f64, right: f64, distance: f64) -> f64 {
    libm::atan((left - right) / distance)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For a cambered wheel on a tilted road, the loaded radius places the contact point on the road. The distance to the road determines the force,
    /// and the force determines the radius.
    #[test]
    fn the_law_of_the_tyre_gives_the_distance_to_the_road() {
        let tyre = Tyre {
            radius: 317.25,
            stiffness: Some(202.0),
        };
        let o = Vec3::new(0.02, -1.0, 0.09).normalize();
        let normal = Vec3::new(0.0, 0.05, 1.0).normalize();
        for distance in [280.0, 330.0] {
            // Road below the origin by `distance` along the normal.
            let tilt = (1.0 - o.dot(&normal).powi(2)).sqrt();
            let r = distance / tilt;
            let force = 202.0 * (317.25 - r) * tilt;
            assert!((loaded_radius(&tyre, force, &o, &normal) - r).abs() < 1e-12);
            let contact = contact_point(&Vec3::zeros(), &o, &normal, r);
            assert!((contact.dot(&normal) + distance).abs() < 1e-12);
            let lever = lever(&o, &normal, r, &tyre);
            assert!((lever.norm() - r.min(317.25)).abs() < 1e-12);
            assert!(lever.cross(&contact).norm() < 1e-9);
        }
    }
}
