//! Steering geometry of an axle: turn radius and Ackerman. Angles in radians, positive to the right; `y` of a contact point in the
//! vehicle frame, positive to the right. Source: guide page `kc`, section "Steering geometry".

use super::Side;

/// Inside steer angles below this are not evaluated, 0.1 degrees: Adams/Car does not either.
pub(crate) const LEAST_STEER: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// The turn radius of a straight wheel, in length units, as Adams/Car writes it.
pub(crate) const STRAIGHT: f64 = 1e5;

/// What two steered wheels show.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Steering {
    /// Steer angle of left and right.
    pub steer: [f64; 2],
    /// y of the contact points.
    pub y: [f64; 2],
    /// Distance of the axles.
    pub wheelbase: f64,
}

impl Steering {
    /// The inside wheel: right for a right turn. `None` straight ahead.
    pub(crate) fn inside(&self) -> Option<Side> {
        let mean = self.steer[0] + self.steer[1];
        let side = if mean > 0.0 { Side::Right } else { Side::Left };
        (self.steer[side.index()].abs() >= LEAST_STEER).then_some(side)
    }

    /// `L / tan(steer of the inside wheel) + y of the inside wheel`, positive for a right turn.
    pub fn turn_radius(&self) -> Option<f64> {
        let k = self.inside()?.index();
        Some(self.wheelbase / libm::tan(self.steer[k]) + self.y[k])
    }

    /// `atan(L / R)`; zero straight ahead.
    pub fn ackerman_angle(&self) -> f64 {
        self.turn_radius()
            .map_or(0.0, |r| libm::atan(self.wheelbase / r))
    }

    /// The steer angle the geometry asks for: inside its own, outside `atan(L / (R - y))`; zero straight ahead.
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

    /// Steer angle less the ideal one; zero straight ahead.
    pub fn error(&self, side: Side) -> f64 {
        self.inside()
            .map_or(0.0, |_| self.steer[side.index()] - self.ideal(side))
    }

    /// `steer right - steer left`.
    pub fn ackerman(&self) -> f64 {
        self.steer[1] - self.steer[0]
    }

    /// `2 sqrt((|R| + T/2)^2 + L^2)`.
    pub fn outside_diameter(&self, track: f64) -> f64 {
        let radius = self.turn_radius().unwrap_or(STRAIGHT);
        2.0 * libm::hypot(radius.abs() + track / 2.0, self.wheelbase)
    }

    /// `100 (inside - outside) / (inside - ideal outside)`; 100 straight ahead. The formula is not confirmed by real results, which
    /// show only clipped values.
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

    /// Both wheels on circles about one point of the rear axle: no error, 100 percent.
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
