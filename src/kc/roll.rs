//! Characteristics of an axle in roll, from the compliance of the wheel centres.
//!
//! `track` is the distance between the contact points. Coefficients refer to the roll angle of the line through the loaded tyres on the
//! road, so they include the compliance of the tyres. Source of every formula: guide page `kc`, section "Ride and roll".

use super::wheel::angle_rates;
use super::{Compliance, Side};
use admire_solver::mechanics::Vec3;

/// Returns the difference of the travels, left minus right, per unit of opposite vertical loads on the wheels:
/// `D = C33 - C39 - C93 + C99`. The travels and loads are those of the points of `c`: wheel centres or contact points.
pub(crate) fn opposed_travel(c: &Compliance) -> f64 {
    c.c(3, 3) - c.c(3, 9) - c.c(9, 3) + c.c(9, 9)
}

/// Returns the difference of the travels under opposite loads, with the tyres included: `Dt = D + 2 / Kt`, or D without tyre
/// stiffness.
pub(crate) fn opposed_travel_on_tyres(c: &Compliance, tyre: Option<f64>) -> f64 {
    opposed_travel(c) + tyre.map_or(0.0, |k| 2.0 / k)
}

/// Returns the suspension roll rate, the roll moment per radian of the suspension's roll angle: `T^2 / D`.
pub fn suspension_roll_rate(c: &Compliance, track: f64) -> f64 {
    track * track / opposed_travel(c)
}

/// Returns the total roll rate, the roll moment per radian of roll angle with the tyres in series: `T^2 / Dt`.
pub fn total_roll_rate(c: &Compliance, track: f64, tyre: Option<f64>) -> f64 {
    track * track / opposed_travel_on_tyres(c, tyre)
}

/// Returns the roll rate of the axle on its tyres with the body held: `T^2 / sum of c t / (c + t)`. The sum is over the two wheels, with c
/// = C33 - C39 on the left, c = C99 - C93 on the right, and t = 1 / Kt.
pub(crate) fn tramp_rate(c: &Compliance, track: f64, tyre: f64) -> f64 {
    let t = 1.0 / tyre;
    let sum: f64 = Side::BOTH
        .into_iter()
        .map(|side| {
            let own = c.antiphase(side, 3, 3);
            own * t / (own + t)
        })
        .sum();
    track * track / sum
}

/// Returns steer per roll angle, positive to the left with the left wheel up: the derivative of the steer angle atan(o.x / o.y) under
/// opposite vertical loads at the contact points, +1 on the left and -1 on the right.
///
/// `at_patch` is the compliance at the contact points. Let o be the spin axis and `th = C(4..6, 3) - C(4..6, 9)` the rotation of the left wheel per
/// load. The steer angle then changes as in [`ride_steer`](super::ride::ride_steer). The roll angle is `Dt / T`; Dt refers to the contact points, not
/// to the wheel centres.
pub fn roll_steer(
    at_patch: &Compliance,
    side: Side,
    o: &Vec3,
    track: f64,
    tyre: Option<f64>,
) -> f64 {
    let turn = Vec3::from([4, 5, 6].map(|i| at_patch.antiphase(side, i, 3)));
    let load = -side.outboard_sign();
    -load * angle_rates(side, o, &turn).steer * track / opposed_travel_on_tyres(at_patch, tyre)
}

/// Returns inclination to the road per roll angle. It is `1 + (C43 - C49) T / Dt` on the left and `1 - (C10,9 - C10,3) T / Dt` on the
/// right.
pub(crate) fn roll_camber(c: &Compliance, side: Side, track: f64, tyre: Option<f64>) -> f64 {
    1.0 - side.outboard_sign() * c.antiphase(side, 4, 3) * track / opposed_travel_on_tyres(c, tyre)
}

/// Returns caster per roll angle. It is `(C53 - C59) T / Dt` on the left and `(C11,3 - C11,9) T / Dt` on the right.
pub fn roll_caster(c: &Compliance, side: Side, track: f64, tyre: Option<f64>) -> f64 {
    -side.outboard_sign() * c.antiphase(side, 5, 3) * track / opposed_travel_on_tyres(c, tyre)
}
