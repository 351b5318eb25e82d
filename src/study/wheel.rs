//! Camber and steer of the wheel as defined in guide/study.md.

use super::settings::SpinAxis;
use admire_solver::mechanics::{Pose, Vec3};

/// Wheel reading of a K&C rig.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct WheelReading {
    /// Wheel marker origin in ground.
    pub position: Vec3,
    /// Camber in degrees, positive when the top of the wheel leans outboard.
    pub camber_deg: f64,
    /// Steer in degrees, right-handed about +z, in (-180, 180].
    pub steer_deg: f64,
}

/// Unit spin axis at design in ground axes, and its relation to the axes of the marker.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SpinDirection {
    /// Axis of the marker: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Sense of the spin axis along this marker axis: +1 or -1.
    pub sense: f64,
    /// Spin axis at design, pointing outboard.
    pub s0: Vec3,
}

impl SpinDirection {
    /// Determines the spin axis from the wheel marker at the deck's design position.
    ///
    /// Without a sign in the study the axis points outboard: away from the vehicle's middle, which lies at the origin of the ground frame
    /// along the spin axis.
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

    /// Returns the current spin axis of the wheel marker.
    pub fn now(&self, marker: &Pose) -> Vec3 {
        marker.R.column(self.axis) * self.sense
    }

    /// Returns the reading of the rig for this pose of the wheel marker.
    pub fn reading(&self, marker: &Pose) -> WheelReading {
        let s = self.now(marker);
        WheelReading {
            position: marker.p,
            camber_deg: camber_deg(&self.s0, &s),
            steer_deg: steer_deg(&self.s0, &s),
        }
    }
}

/// Returns the camber angle `asin(s0.z) - asin(s.z)` in degrees.
pub fn camber_deg(s0: &Vec3, s: &Vec3) -> f64 {
    (libm::asin(s0.z.clamp(-1.0, 1.0)) - libm::asin(s.z.clamp(-1.0, 1.0))).to_degrees()
}

/// Returns the steer angle `atan2(s.y, s.x) - atan2(s0.y, s0.x)` in degrees, wrapped to (-180, 180].
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
        // The spin axis has four digits, so its length is 1 only to within 3e-4.
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
