//! Camber and steer angles of a wheel, as defined in guide/study.md.

use super::settings::SpinAxis;
use admire_solver::mechanics::{Pose, Vec3};

/// Reading of a wheel on a kinematics and compliance (K&C) rig.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct WheelReading {
    /// Position of the wheel marker's origin in ground.
    pub position: Vec3,
    /// Camber in degrees, positive if the top of the wheel leans outboard.
    pub camber_deg: f64,
    /// Steer in degrees, right-handed about +z, in (-180, 180].
    pub steer_deg: f64,
}

/// Spin axis of a wheel, as an axis of the wheel marker with a sense.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SpinDirection {
    /// Axis of the wheel marker: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Sense of the spin axis relative to this marker axis: +1 or -1.
    pub sense: f64,
    /// Unit vector along the spin axis in the design position, in ground axes. It points outboard unless the study states a sign.
    pub s0: Vec3,
}

impl SpinDirection {
    /// Determines the spin axis from the pose of the wheel marker in the design position of the deck.
    ///
    /// If the study states no sign, the axis points outboard. Outboard is the sense in which the marker's position has a positive component
    /// along the axis, since the middle of the vehicle lies at the origin of ground.
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

    /// Returns the spin axis in ground for this pose of the wheel marker.
    pub fn now(&self, marker: &Pose) -> Vec3 {
        marker.R.column(self.axis) * self.sense
    }

    /// Returns the reading that the rig would take for this pose of the wheel marker.
    pub fn reading(&self, marker: &Pose) -> WheelReading {
        let s = self.now(marker);
        WheelReading {
            position: marker.p,
            camber_deg: camber_deg(&self.s0, &s),
            steer_deg: steer_deg(&self.s0, &s),
        }
    }
}

/// Returns the camber angle `asin(s0.z) - asin(s.z)` in degrees. `s0` is the spin axis in the design position, `s` the current spin axis.
pub fn camber_deg(s0: &Vec3, s: &Vec3) -> f64 {
    (libm::asin(s0.z.clamp(-1.0, 1.0)) - libm::asin(s.z.clamp(-1.0, 1.0))).to_degrees()
}

/// Returns the steer angle `atan2(s.y, s.x) - atan2(s0.y, s0.x)` in degrees, wrapped to (-180, 180]. `s0` is the spin axis in the design
/// position, `s` the current spin axis.
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
        // The spin axis of the example has four digits, so its length is 1 only to within 3e-4.
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
