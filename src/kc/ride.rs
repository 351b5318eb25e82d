//! Rates and changes per wheel travel, from the compliance of the wheel centres; both wheels loaded in phase.
//!
//! Compliance rows count rotations about +Z positive to the left; the ride steer column counts to the right. Source of every formula:
//! guide page `kc`, section "Ride and roll".

use super::{Compliance, Side};

/// Vertical force per travel of the wheel centre, no tyre: `1 / (C33 + C39)`.
pub fn wheel_rate(c: &Compliance, side: Side) -> f64 {
    1.0 / c.in_phase(side, 3, 3)
}

/// Wheel rate and tyre in series: `k Kt / (k + Kt)`.
pub fn ride_rate(wheel_rate: f64, tyre: f64) -> f64 {
    wheel_rate * tyre / (wheel_rate + tyre)
}

/// Steer per travel, positive to the right in jounce: `-(C63 + C69) / (C33 + C39)`. Exact at zero camber; the tangent of a bounce test is
/// that of the steer angle itself.
pub fn ride_steer(c: &Compliance, side: Side) -> f64 {
    -c.in_phase(side, 6, 3) / c.in_phase(side, 3, 3)
}

/// Camber per travel, positive with the top outboard: `(C43 + C49) / (C33 + C39)`, the other sign on the right.
pub(crate) fn ride_camber(c: &Compliance, side: Side) -> f64 {
    -side.outboard() * c.in_phase(side, 4, 3) / c.in_phase(side, 3, 3)
}

/// Caster per travel: `(C53 + C59) / (C33 + C39)`.
pub(crate) fn ride_caster(c: &Compliance, side: Side) -> f64 {
    c.in_phase(side, 5, 3) / c.in_phase(side, 3, 3)
}

/// Natural frequency of a corner in Hz: `sqrt(k / m) / 2 pi`, `mass` the sprung mass on that corner, the rate in force per length and
/// `consistency` the UCF of the units.
pub(crate) fn ride_frequency(ride_rate: f64, mass: f64, consistency: f64) -> f64 {
    (ride_rate * consistency / mass).sqrt() / std::f64::consts::TAU
}
