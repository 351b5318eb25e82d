//! Steering geometry of an axle: turn radius and Ackerman. Angles are in radians, positive to the right. `y` of a contact point is in the
//! vehicle frame, positive to the right. Source: guide page `kc`, section "Steering geometry".

use super::Side;

/// Smallest inside steer angle that is evaluated, 0.1 degrees, as in Adams/Car.
pub(crate) const LEAST_STEER: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Turn radius before the first evaluated state, in length units, as in Adams/Car.
const STRAIGHT: f64 = 1e5;
/// Largest percentage that Adams/Car writes.
const MOST_PERCENT: f64 = 999.0;

/// Geometry of two steered wheels.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Steering {
    /// Steer angles, left and right.
    pub steer: [f64; 2],
    /// Lateral coordinates y of the contact points, left and right.
    pub y: [f64; 2],
    /// Wheelbase.
    pub wheelbase: f64,
    /// Turn radius of the last evaluated state of the test, if any.
    pub last_radius: Option<f64>,
}

impl Steering {
    /// Returns the inside wheel: right for a right turn. The mean steer angle decides the direction of the turn. `None` unless the inside
    /// wheel itself is turned that way by [`LEAST_STEER`]; wheels with toe-in on both sides never are.
    pub(crate) fn inside(&self) -> Option<Side> {
        let right = self.steer[0] + self.steer[1] > 0.0;
        let side = if right { Side::Right } else { Side::Left };
        let inward = side.outboard_sign() * self.steer[side.index()];
        (inward >= LEAST_STEER).then_some(side)
    }

    /// Returns the turn radius R, positive for a right turn: `L / tan(steer) + y`, with steer and y of the inside wheel. `None` without an
    /// inside wheel.
    pub fn turn_radius(&self) -> Option<f64> {
        let k = self.inside()?.index();
        Some(self.wheelbase / libm::tan(self.steer[k]) + self.y[k])
    }

    /// Returns the turn radius R. For a state without a turn radius, returns that of the last evaluated state of the test, or 1e5 length units
    /// before the first evaluated state.
    pub fn kept_radius(&self) -> f64 {
        self.turn_radius().or(self.last_radius).unwrap_or(STRAIGHT)
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

    /// Returns the steer angle minus the ideal steer angle.
    pub fn error(&self, side: Side) -> f64 {
        self.steer[side.index()] - self.ideal(side)
    }

    /// Returns the Ackerman difference `steer right - steer left`.
    pub fn ackerman(&self) -> f64 {
        self.steer[1] - self.steer[0]
    }

    /// Returns the outside turn diameter `2 sqrt((|R| + T/2)^2 + L^2)` with the radius R of [`Self::kept_radius`].
    pub fn outside_diameter(&self, track: f64) -> f64 {
        2.0 * libm::hypot(self.kept_radius().abs() + track / 2.0, self.wheelbase)
    }

    /// Returns percent Ackerman `100 (inside - outside) / (inside - ideal outside)`, cut at 999; 100 straight ahead. Real results contain only
    /// these two values, so they confirm the cut and not the formula. That negative values are cut at -999 is an assumption.
    pub fn percent(&self) -> f64 {
        let Some(inside) = self.inside() else {
            return 100.0;
        };
        let (i, o) = (inside.index(), inside.other());
        let percent =
            100.0 * (self.steer[i] - self.steer[o.index()]) / (self.steer[i] - self.ideal(o));
        percent.clamp(-MOST_PERCENT, MOST_PERCENT)
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
                last_radius: None,
            };
            assert!((all.turn_radius().unwrap() - radius).abs() < 1e-8);
            for side in Side::BOTH {
                assert!(all.error(side).abs() < 1e-14);
            }
            assert!((all.percent() - 100.0).abs() < 1e-9);
            assert!((all.ackerman_angle() - (wheelbase / radius).atan()).abs() < 1e-14);
        }
    }

    /// Toe-in on both sides is not a turn, however large it is. Toe-in added to a turn of both wheels does not hide the turn.
    #[test]
    fn toe_in_on_both_sides_is_not_evaluated() {
        let of = |left: f64, right: f64| Steering {
            steer: [left, right],
            y: [-770.0, 770.0],
            wheelbase: 2700.0,
            last_radius: Some(4321.0),
        };
        for (left, right) in [(0.05, -0.04), (0.04, -0.05), (0.03, -0.03)] {
            let all = of(left, right);
            assert_eq!((all.turn_radius(), all.percent()), (None, 100.0));
            assert_eq!((all.kept_radius(), all.ackerman_angle()), (4321.0, 0.0));
            // The ideal angle is 0, so the error is the steer angle itself.
            assert_eq!(Side::BOTH.map(|side| all.error(side)), [left, right]);
        }
        assert_eq!(of(0.004, 0.01).inside(), Some(Side::Right));
        assert_eq!(of(-0.01, -0.004).inside(), Some(Side::Left));
        assert_eq!(of(0.0016, 0.0029).percent(), 999.0);
    }
}
