//! Steering geometry of an axle: turn radius and Ackerman. Angles are in radians, positive to the right. `y` of a contact point is in the
//! vehicle frame, positive to the right. Source: guide page `kc`, section "Steering geometry".

use super::Side;

/// Smallest inside steer angle that is evaluated, 0.1 degrees, as in Adams/Car.
pub(crate) const LEAST_STEER: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Turn radius that is reported for straight wheels, in length units, as in Adams/Car.
pub(crate) const STRAIGHT: f64 = 1e5;

/// Geometry of two steered wheels.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Steering {
    /// Steer angles, left and right.
    pub steer: [f64; 2],
    /// Lateral coordinates y of the contact points, left and right.
    pub y: [f64; 2],
    /// Wheelbase.
    pub wheelbase: f64,
}

impl Steering {
    /// Returns the inside wheel: right for a right turn. `None` straight ahead.
    pub(crate) fn inside(&self) -> Option<Side> {
        let mean = self.steer[0] + self.steer[1];
        let side = if mean > 0.0 { Side::Right } else { Side::Left };
        (self.steer[side.index()].abs() >= LEAST_STEER).then_some(side)
    }

    /// Returns the turn radius R, positive for a right turn: `L / tan(steer) + y`, with steer and y of the inside wheel. `None` straight
    /// ahead.
    pub fn turn_radius(&self) -> Option<f64> {
        let k = self.inside()?.index();
        Some(self.wheelbase / libm::tan(self.steer[k]) + self.y[k])
    }

    /// Returns the Ackerman angle `atan(L / R)`; zero straight ahead.
    pub fn ackerman_angle(&self) -> f64 {
        self.turn_radius()
            .map_or(0.0, |r| libm::atan(self.wheelbase / r))
    }

    /// Returns the ideal steer angle, zero straight ahead. For the inside wheel it is the wheel's own angle, for the outside wheel
    /// `atan(L / (R - y))`.
    pub fn ideal(&self, side: Side) -> f64 {
        let (Some(inside), Some(radius)) = (self.inside(), self.turn_radius()) else {
            return 0.0;
        };
        if side == inside {
            self.steer[side.index()]
        } else {
            libm::atan(self.wheelbase / (radius - self.y[side.index()]))
        }
    }

    /// Returns the steer angle minus the ideal steer angle; zero straight ahead.
    pub fn error(&self, side: Side) -> f64 {
        self.inside()
            .map_or(0.0, |_| self.steer[side.index()] - self.ideal(side))
    }

    /// Returns the Ackerman difference `steer right - steer left`.
    pub fn ackerman(&self) -> f64 {
        self.steer[1] - self.steer[0]
    }

    /// Returns the outside turn diameter `2 sqrt((|R| + T/2)^2 + L^2)`.
    pub fn outside_diameter(&self, track: f64) -> f64 {
        let radius = self.turn_radius().unwrap_or(STRAIGHT);
        2.0 * libm::hypot(radius.abs() + track / 2.0, self.wheelbase)
    }

    /// Returns percent Ackerman `100 (inside - outside) / (inside - ideal outside)`; 100 straight ahead. The formula is not confirmed by
    /// real results, which contain only clipped values.
    pub(crate) fn percent(&self) -> f64 {
        let Some(inside) = self.inside() else {
            return 100.0;
        };
        let (i, o) = (inside.index(), inside.other());
        100.0 * (self.steer[i] - self.steer[o.index()]) / (self.steer[i] - self.ideal(o))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If both wheels turn on circles about one point of the rear axle, the steer error is zero and Ackerman is 100 percent.
    #[test]
    fn true_ackerman_has_no_error() {
        for radius in [6000.0_f64, -9000.0] {
            let (wheelbase, y) = (2700.0_f64, [-770.0, 770.0]);
            let steer = y.map(|y: f64| (wheelbase / (radius - y)).atan());
            let all = Steering {
                steer,
                y,
                wheelbase,
            };
            assert!((all.turn_radius().unwrap() - radius).abs() < 1e-8);
            for side in Side::BOTH {
                assert!(all.error(side).abs() < 1e-14);
            }
            assert!((all.percent() - 100.0).abs() < 1e-9);
            assert!((all.ackerman_angle() - (wheelbase / radius).atan()).abs() < 1e-14);
        }
    }
}
