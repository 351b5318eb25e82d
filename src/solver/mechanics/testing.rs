//! Poses, increments and transformations to ground, shared by the tests of force laws and constraints.

use super::{Pose, RelativeMotion, Vec3, Vec6, exp, unwrap_near};

/// Returns two marker poses in general position, with a relative rotation of about `tilt` radians.
pub(crate) fn general_pair(tilt: f64) -> (Pose, Pose) {
    let j = Pose {
        p: Vec3::new(12.0, -7.0, 3.0),
        R: exp(&Vec3::new(0.7, -0.4, 1.1)),
    };
    let inside = Pose {
        p: Vec3::new(0.9, -0.7, 1.3),
        R: exp(&(Vec3::new(0.6, -0.5, 0.62) * tilt)),
    };
    (j.compose(&inside), j)
}

/// Returns the relative motion after the change `by` = (change of `p_ij_j`, rotation vector), both in J axes. The angles are those nearest to
/// the angles before the change.
pub(crate) fn advanced(motion: &RelativeMotion, by: &Vec6) -> RelativeMotion {
    let R_ji = exp(&Vec3::new(by[3], by[4], by[5])) * motion.R_ji;
    RelativeMotion {
        p_ij_j: motion.p_ij_j + Vec3::new(by[0], by[1], by[2]),
        R_ji,
        angles: super::projected_angles(&R_ji).zip_map(&motion.angles, unwrap_near),
    }
}

/// Returns a pose displaced by `by` = (translation, rotation vector), both in ground axes.
pub(crate) fn displaced(pose: &Pose, by: &Vec6) -> Pose {
    Pose {
        p: pose.p + Vec3::new(by[0], by[1], by[2]),
        R: exp(&Vec3::new(by[3], by[4], by[5])) * pose.R,
    }
}

/// Converts a wrench on I in J axes to a pair of wrenches in ground axes: the wrench on I at the origin of I, and the reaction on J at the
/// origin of J (guide/formats.md 2.7).
pub(crate) fn in_ground(wrench: &Vec6, i: &Pose, j: &Pose) -> (Vec6, Vec6) {
    let F = j.R * Vec3::new(wrench[0], wrench[1], wrench[2]);
    let T = j.R * Vec3::new(wrench[3], wrench[4], wrench[5]);
    let T_j = -T - (i.p - j.p).cross(&F);
    (
        Vec6::new(F.x, F.y, F.z, T.x, T.y, T.z),
        Vec6::new(-F.x, -F.y, -F.z, T_j.x, T_j.y, T_j.z),
    )
}

/// Returns the moment about the point `about` of a wrench that acts at the point `p`. All vectors are in ground axes.
pub(crate) fn moment(wrench: &Vec6, p: &Vec3, about: &Vec3) -> Vec3 {
    Vec3::new(wrench[3], wrench[4], wrench[5])
        + (p - about).cross(&Vec3::new(wrench[0], wrench[1], wrench[2]))
}

/// Returns a reproducible vector in six dimensions, with components between -0.4 and 0.4.
pub(crate) fn direction(seed: usize) -> Vec6 {
    Vec6::from_fn(|k, _| number(6 * seed + k) - 1.0)
}

/// Returns the n-th number of a reproducible sequence without a pattern. All numbers are in [0.6, 1.4].
pub(crate) fn number(n: usize) -> f64 {
    0.6 + 0.8 * ((n as f64 + 1.0) * 0.618_033_988_749_894_8).fract()
}
