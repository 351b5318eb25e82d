//! GEAR as a sum of joint displacements. Knows no model: poses on the carrier are given.

use super::Measure;
use crate::mechanics::{Pose, Vec3};

/// One joint displacement in a COUPLER or GEAR, with its factor.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Term {
    /// Displacement of the joint's I relative to its J: `Measure::Translation(2)` or `Measure::Angle(2)`.
    pub measure: Measure,
    /// Length or radians times this.
    pub scale: f64,
}

/// Which freedoms a geared joint has.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are the manual's.
pub(crate) enum GearedJoint {
    Revolute,
    Translational,
    Cylindrical,
}

/// The speed along z of the CV marker that a geared part has at the CV point, per unit of its joint's displacements.
///
/// Both J markers and the CV marker sit on one carrier, so with `r` from the J origin to the CV origin and all axes taken in the
/// carrier the speed of the part carrying I is `(zj x r) . z_cv` per radian and `zj . z_cv` per length, which are constant: the
/// equality of the two parts' speeds integrates to `sum a q (first) - sum a q (second) = const`, the constant being its value
/// in the design. Returned are the terms of one joint with `factor` (+1 for the first joint, -1 for the second); a CYLINDRICAL
/// joint gives two. Source: derived from the common-velocity wording of Adams Solver help, `state_gear`.
pub(crate) fn gear_terms(kind: GearedJoint, j: &Pose, cv: &Pose, factor: f64) -> [Option<Term>; 2] {
    let zj: Vec3 = j.R.column(2).into_owned();
    let along: Vec3 = cv.R.column(2).into_owned();
    let rotation = Term {
        measure: Measure::Angle(2),
        scale: factor * zj.cross(&(cv.p - j.p)).dot(&along),
    };
    let translation = Term {
        measure: Measure::Translation(2),
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

    /// The terms are the speed of the geared part's point at the CV marker, for a carrier in general position.
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

    /// External spur gears of radii 30 and 60 on parallel axes: 30 q1 = -60 q2 (they turn against each other, half as fast).
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
