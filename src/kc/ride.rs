//! Rates and changes per wheel travel from the compliance of the wheel centres, with both wheels loaded in phase.
//!
//! Compliance rows count rotations about +Z positive to the left; the ride steer column is positive to the right. Source of every formula:
//! guide page `kc`, section "Ride and roll".

use super::wheel::angle_rates;
use super::{Compliance, Side};
use admire_solver::mechanics::Vec3;

/// Returns the wheel rate, the vertical force per travel of the wheel centre without tyre: `1 / (C33 + C39)`.
pub fn wheel_rate(c: &Compliance, side: Side) -> f64 {
    1.0 / c.in_phase(side, 3, 3)
}

/// Returns the ride rate, the wheel rate and the tyre stiffness in series: `k Kt / (k + Kt)`.
pub fn ride_rate(wheel_rate: f64, tyre: f64) -> f64 {
    wheel_rate * tyre / (wheel_rate + tyre)
}

/// Returns steer per travel, positive to the right in jounce: the derivative of the steer angle atan(o.x / o.y) with respect to the travel.
///
/// Let o be the spin axis and `th = C(4..6, 3) + C(4..6, 9)` the rotation of the wheel per vertical load. Then `do = th x o`, and the steer angle
/// changes by `(o.y do.x - o.x do.y) / (o.x^2 + o.y^2)`. The travel is `C33 + C39`.
pub fn ride_steer(c: &Compliance, side: Side, o: &Vec3) -> f64 {
    let turn = Vec3::from([4, 5, 6].map(|i| c.in_phase(side, i, 3)));
    angle_rates(side, o, &turn).steer / c.in_phase(side, 3, 3)
}

/// Returns camber per travel, positive with the top outboard. It is `(C43 + C49) / (C33 + C39)` on the left, and the same with opposite
/// sign on the right.
pub(crate) fn ride_camber(c: &Compliance, side: Side) -> f64 {
    -side.outboard_sign() * c.in_phase(side, 4, 3) / c.in_phase(side, 3, 3)
}

/// Returns caster per travel: `(C53 + C59) / (C33 + C39)`.
pub(crate) fn ride_caster(c: &Compliance, side: Side) -> f64 {
    c.in_phase(side, 5, 3) / c.in_phase(side, 3, 3)
}

/// Returns the natural frequency of a corner in Hz: `sqrt(k / m) / 2 pi`. `ride_rate` is in force per length, `mass` is the sprung mass of
/// the corner, and `consistency` is the UCF (unit consistency factor) of the deck.
pub(crate) fn ride_frequency(ride_rate: f64, mass: f64, consistency: f64) -> f64 {
    (ride_rate * consistency / mass).sqrt() / std::f64::consts::TAU
}
