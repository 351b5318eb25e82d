//! GEAR as a weighted sum of joint displacements. The module is independent of the model: the caller supplies the marker poses on the
//! carrier.

use super::RelativeCoordinate;
use crate::mechanics::{Pose, Vec3};

/// One joint displacement in a COUPLER or GEAR, with its factor.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct GearTerm {
    /// Displacement of the joint's I marker relative to its J marker: `RelativeCoordinate::Translation(2)` or
    /// `RelativeCoordinate::Angle(2)`.
    pub measure: RelativeCoordinate,
    /// Factor that multiplies the displacement. The displacement is a length or an angle in radians.
    pub scale: f64,
}

/// Type of a geared joint, which determines its degrees of freedom.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are those of the manual.
pub(crate) enum GearedJoint {
    Revolute,
    Translational,
    Cylindrical,
}

/// Returns the terms that one joint contributes to the GEAR equation, multiplied by `factor` (+1 for the first joint, -1 for the second).
///
/// Each scale is a velocity per unit rate of the joint displacement: the velocity of the geared part's point at the CV origin, along z of
/// the CV marker. Both J markers and the CV marker are fixed on one carrier. All vectors are in carrier axes, and `r` is the vector from
/// the J origin to the CV origin. The part that carries I moves at `(zj x r) . z_cv` per radian and at `zj . z_cv` per unit length; both
/// factors are constant. Equal velocities of the two parts therefore integrate to `sum a q (first) - sum a q (second) = const`. The
/// constant is the value of the left-hand side in the design position. A CYLINDRICAL joint gives two terms, the other joint types give one
/// term. Source: derived from the common-velocity definition in the Adams Solver help, `state_gear`.
pub(crate) fn gear_terms(
    kind: GearedJoint,
    j: &Pose,
    cv: &Pose,
    factor: f64,
) -> [Option<GearTerm>; 2] {
    let zj: Vec3 = j.R.column(2).into_owned();
    let along: Vec3 = cv.R.column(2).into_owned();
    let rotation = GearTerm {
        measure: RelativeCoordinate::Angle(2),
        scale: factor * zj.cross(&(cv.p - j.p)).dot(&along),
    };
    let translation = GearTerm {
        measure: RelativeCoordinate::Translation(2),
        scale: factor * zj.dot(&along),
    };
    match kind {
        GearedJoint::Revolute => [Some(rotation), None],
        GearedJoint::Translational => [Some(translation), None],
        GearedJoint::Cylindrical => [Some(rotation), Some(translation)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::{Mat3, exp};

    /// The scales equal the velocity of the geared part's point at the CV marker, along z of that marker, for a carrier in general
    /// position.
    #[test]
    fn terms_are_the_speed_along_the_cv_axis() {
        let carrier = Pose {
            p: Vec3::new(5.0, -2.0, 8.0),
            R: exp(&Vec3::new(0.4, 1.1, -0.6)),
        };
        let place = |p: Vec3, turn: Vec3| carrier.compose(&Pose { p, R: exp(&turn) });
        let j = place(Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.2, -0.8, 0.5));
        let cv = place(Vec3::new(-4.0, 9.0, 1.0), Vec3::new(-0.2, 0.3, 0.9));
        // The point of the geared part that sits at the CV origin, in J axes.
        let point = j.R.transpose() * (cv.p - j.p);
        let along = |turn: f64, shift: f64| {
            let moved = j.p + j.R * (exp(&Vec3::new(0.0, 0.0, turn)) * point + Vec3::z() * shift);
            moved.dot(&cv.R.column(2))
        };
        let h = 1e-5;
        let [rotation, translation] =
            gear_terms(GearedJoint::Cylindrical, &j, &cv, 1.0).map(|term| term.expect("both"));
        let turning = (along(h, 0.0) - along(-h, 0.0)) / (2.0 * h);
        let sliding = (along(0.0, h) - along(0.0, -h)) / (2.0 * h);
        assert!((rotation.scale - turning).abs() < 1e-8);
        assert!((translation.scale - sliding).abs() < 1e-8);
        assert!(rotation.scale.abs() > 0.1 && translation.scale.abs() > 0.1);
    }

    /// External spur gears of radii 30 and 60 on parallel axes obey 30 q1 = -60 q2: the second gear turns backwards at half the speed.
    #[test]
    fn spur_gears_turn_against_each_other() {
        let axis = |x: f64| Pose {
            p: Vec3::new(x, 0.0, 0.0),
            R: Mat3::identity(),
        };
        // The CV marker's z points along global y, the common direction of motion.
        let cv = Pose {
            p: Vec3::new(30.0, 0.0, 0.0),
            R: Mat3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0),
        };
        let [first, none] = gear_terms(GearedJoint::Revolute, &axis(0.0), &cv, 1.0);
        let [second, _] = gear_terms(GearedJoint::Revolute, &axis(90.0), &cv, -1.0);
        assert!(none.is_none());
        let (a, b) = (first.expect("turns").scale, second.expect("turns").scale);
        assert_eq!((a, b), (30.0, 60.0));
    }
}
