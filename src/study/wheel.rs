//! Camber and steer of the wheel as guide/study.md defines them.

use super::settings::SpinAxis;
use admire_solver::mechanics::{Pose, Vec3};

/// What a K&C rig reads at the wheel.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct WheelReading {
    /// Wheel marker origin in ground.
    pub position: Vec3,
    /// Positive when the top of the wheel leans outboard. Degrees.
    pub camber_deg: f64,
    /// Right-handed about +z, in (-180, 180]. Degrees.
    pub steer_deg: f64,
}

/// The unit spin axis at design, in ground axes, and the sense in which the marker axis gives it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SpinDirection {
    /// 0, 1, 2: which axis of the marker.
    pub axis: usize,
    /// +1 or -1.
    pub sense: f64,
    /// The spin axis at design, pointing outboard.
    pub s0: Vec3,
}

impl SpinDirection {
    /// From the wheel marker at the deck's design position.
    ///
    /// Without a sign in the study the sense is the one that points outboard: away from the vehicle's middle, which lies at the
    /// origin of the ground frame along the spin axis.
    pub fn at_design(marker: &Pose, axis: SpinAxis) -> Self {
        let column: Vec3 = marker.R.column(axis.axis).into();
        let sense = match axis.sign {
            Some(sign) => f64::from(sign),
            None if column.dot(&marker.p) < 0.0 => -1.0,
            None => 1.0,
        };
        Self {
            axis: axis.axis,
            sense,
            s0: column * sense,
        }
    }

    /// The spin axis of the wheel marker now.
    pub fn now(&self, marker: &Pose) -> Vec3 {
        marker.R.column(self.axis) * self.sense
    }

    /// What the rig reads with the wheel marker here.
    pub fn reading(&self, marker: &Pose) -> WheelReading {
        let s = self.now(marker);
        WheelReading {
            position: marker.p,
            camber_deg: camber_deg(&self.s0, &s),
            steer_deg: steer_deg(&self.s0, &s),
        }
    }
}

/// `asin(s0.z) - asin(s.z)` in degrees.
pub fn camber_deg(s0: &Vec3, s: &Vec3) -> f64 {
    (libm::asin(s0.z.clamp(-1.0, 1.0)) - libm::asin(s.z.clamp(-1.0, 1.0))).to_degrees()
}

/// `atan2(s.y, s.x) - atan2(s0.y, s0.x)` in degrees, wrapped to (-180, 180].
pub fn steer_deg(s0: &Vec3, s: &Vec3) -> f64 {
    let turn = (libm::atan2(s.y, s.x) - libm::atan2(s0.y, s0.x)).to_degrees();
    180.0 - (180.0 - turn).rem_euclid(360.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_solver::mechanics::Mat3;

    #[test]
    fn the_worked_example_of_the_study_format() {
        // Its spin axis is given to four digits and is a unit vector only to 3e-4.
        let (s0, s) = (Vec3::new(0.0, -1.0, 0.0), Vec3::new(0.01, -0.9997, 0.02));
        assert!((camber_deg(&s0, &s) + 1.146).abs() < 5e-4);
        assert!((steer_deg(&s0, &s) - 0.573).abs() < 5e-4);
    }

    #[test]
    fn steer_wraps() {
        let (s0, s) = (Vec3::new(-1.0, 0.01, 0.0), Vec3::new(-1.0, -0.01, 0.0));
        assert!((steer_deg(&s0, &s) - 1.14588).abs() < 1e-4);
        assert!((steer_deg(&Vec3::x(), &-Vec3::x()) - 180.0).abs() < 1e-12);
    }

    #[test]
    fn an_unsigned_axis_points_outboard() {
        let axis = SpinAxis {
            axis: 1,
            sign: None,
        };
        let left = Pose {
            p: Vec3::new(-15.0, -760.0, 300.0),
            R: Mat3::identity(),
        };
        let right = Pose {
            p: Vec3::new(-15.0, 760.0, 300.0),
            R: Mat3::identity(),
        };
        assert_eq!(SpinDirection::at_design(&left, axis).s0.y, -1.0);
        assert_eq!(SpinDirection::at_design(&right, axis).s0.y, 1.0);
        let literal = SpinAxis {
            axis: 1,
            sign: Some(1),
        };
        assert_eq!(SpinDirection::at_design(&left, literal).s0.y, 1.0);
    }
}
