//! Pieces of functions that are not smooth: on which one a motion is, and how far it is from the end of it.
//!
//! A step of an integrator is smooth only if every function stays on one formula in it. So a motion holds each IMPACT, BISTOP, ABS, SIGN,
//! DIM, MAX, MIN, AINT, ANINT, MOD and IF on the piece it began with, beyond its end too, and looks after each step whether that end was passed.

use super::Fault;
use super::impact::Stop;
use super::intrinsic::extreme;

/// The piece that a function is held on; none: that of its arguments.
pub(crate) type Piece = Option<i64>;

/// What was seen of a function that has pieces.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Seen {
    /// The piece of its arguments; none if it was not evaluated, as in the parts of an IF that are not chosen.
    pub piece: Piece,
    /// Below zero on the piece that it is held on, zero at its end, above zero beyond.
    pub excess: f64,
}

impl Seen {
    /// Not evaluated.
    pub(crate) const NOTHING: Self = Self {
        piece: None,
        excess: f64::NEG_INFINITY,
    };
}

/// The value of a function on a piece.
pub(super) struct Switched {
    pub value: f64,
    pub seen: Seen,
}

/// The piece of a function that is held between its two sides, which push against each other: its value goes from one to the other in a line
/// over this half width of the argument, or the power of two below. What sticks creeps by less than that.
pub(crate) fn between(width: f64) -> i64 {
    (libm::log2(width).floor() as i64).clamp(-1000, -1)
}

/// The half width of a function that is held between its sides.
pub(crate) fn half_width(held: Piece) -> Option<f64> {
    let between = held.filter(|piece| *piece < 0)?;
    Some(libm::exp2(between as f64))
}

/// IF: negative, zero, positive. ABS and DIM: negative, positive.
const NEGATIVE: i64 = 0;
const ZERO: i64 = 1;
const POSITIVE: i64 = 2;

/// The part of an IF: that of the sign of its test, or the one it is held on; the first of the two it is held between.
pub(super) fn part_of(test: f64, held: Piece) -> (i64, Seen) {
    let piece = match test {
        test if test < 0.0 => NEGATIVE,
        test if test > 0.0 => POSITIVE,
        _ => ZERO,
    };
    if let Some(width) = half_width(held) {
        return (NEGATIVE, seen(piece, held, test.abs() - width));
    }
    let on = held.unwrap_or(piece);
    let excess = match on {
        NEGATIVE => test,
        POSITIVE => -test,
        _ => test.abs(),
    };
    (on, seen(piece, held, excess))
}

/// IMPACT and BISTOP: no contact, pressed against the lower stop, in it without a force (the damping would pull), the same of the upper.
const APART: i64 = 0;
const PRESSED: [i64; 2] = [1, 3];
const LEAVING: [i64; 2] = [2, 4];

/// IMPACT(x, xdot, x1, k, e, cmax, d) or BISTOP(x, xdot, x1, x2, k, e, cmax, d) on the piece it is held on, with partial derivatives.
///
/// Beyond the end of the piece the penetration is negative: the spring pulls as it would push, and there is no damping unless d = 0.
pub(super) fn stop_on(a: &[f64], held: Piece, by: &mut [f64]) -> Result<Switched, Fault> {
    by.fill(0.0);
    let (x, rate) = (a[0], a[1]);
    let both = a.len() == 8;
    let law = if both { 4 } else { 3 };
    let (k, e, cmax, d) = (a[law], a[law + 1], a[law + 2], a[law + 3]);
    // Penetrations of the lower and the upper stop.
    let depth = [a[2] - x, if both { x - a[3] } else { f64::NEG_INFINITY }];
    let at = |side: usize| {
        let rate = if side == 0 { rate } else { -rate };
        Stop::at(depth[side], rate, k, e, cmax, d)
    };
    let piece = match (0..2).find(|side| depth[*side] > 0.0) {
        None => APART,
        Some(side) if at(side)?.force > 0.0 => PRESSED[side],
        Some(side) => LEAVING[side],
    };
    let mut value = 0.0;
    let on = held.unwrap_or(piece);
    let excess = if on == APART {
        depth[0].max(depth[1])
    } else {
        let side = usize::from(on > 2);
        let stop = at(side)?;
        let pressed = on == PRESSED[side];
        if pressed {
            // Either way dF/dx = -df/dp, dF/dxdot = df/drate.
            let sign = if side == 0 { 1.0 } else { -1.0 };
            value = sign * stop.force;
            by[0] = -stop.by_p;
            by[1] = stop.by_rate;
            by[2 + side] = stop.by_p;
            for (out, partial) in by[law..].iter_mut().zip(stop.by_law) {
                *out = sign * partial;
            }
        }
        (-depth[side]).max(if pressed { -stop.force } else { stop.force })
    };
    Ok(Switched {
        value,
        seen: seen(piece, held, excess),
    })
}

/// What is seen of a function held on a piece, of which `excess` is zero at the end.
fn seen(piece: i64, held: Piece, excess: f64) -> Seen {
    Seen {
        piece: Some(piece),
        excess: held.map_or(f64::NEG_INFINITY, |_| excess),
    }
}

/// ABS(x) on the piece it is held on: x or -x.
pub(super) fn abs_on(x: f64, held: Piece, by: &mut [f64]) -> Switched {
    let piece = if x < 0.0 { NEGATIVE } else { POSITIVE };
    let sign = if held.unwrap_or(piece) == NEGATIVE {
        -1.0
    } else {
        1.0
    };
    by[0] = sign;
    Switched {
        value: sign * x,
        seen: seen(piece, held, -sign * x),
    }
}

/// DIM(a, b) on the piece it is held on: a - b or zero.
pub(super) fn dim_on(a: f64, b: f64, held: Piece, by: &mut [f64]) -> Switched {
    let piece = if a > b { POSITIVE } else { NEGATIVE };
    let round_off = rounding(a, b);
    if held.unwrap_or(piece) == POSITIVE {
        by.copy_from_slice(&[1.0, -1.0]);
        Switched {
            value: a - b,
            seen: seen(piece, held, b - a - round_off),
        }
    } else {
        by.fill(0.0);
        Switched {
            value: 0.0,
            seen: seen(piece, held, a - b - round_off),
        }
    }
}

/// SIGN(a, b) on the piece it is held on. A piece is which of the two are negative: 1 for a, 2 for b.
pub(super) fn sign_on(a: f64, b: f64, held: Piece, by: &mut [f64]) -> Switched {
    let piece = i64::from(a < 0.0) + 2 * i64::from(b < 0.0);
    if let Some(width) = half_width(held) {
        by.copy_from_slice(&[a.signum() * b / width, a.abs() / width]);
        return Switched {
            value: a.abs() * b / width,
            seen: seen(piece, held, b.abs() - width),
        };
    }
    let on = held.unwrap_or(piece);
    let of_a = if on & 1 == 0 { 1.0 } else { -1.0 };
    let of_b = if on & 2 == 0 { 1.0 } else { -1.0 };
    by.copy_from_slice(&[of_a * of_b, 0.0]);
    Switched {
        value: of_a * of_b * a,
        seen: seen(piece, held, (-of_a * a).max(-of_b * b)),
    }
}

/// AINT(x), or ANINT(x), on the piece it is held on: a whole number.
pub(super) fn whole_on(nearest: bool, x: f64, held: Piece, by: &mut [f64]) -> Switched {
    let own = if nearest { x.round() } else { x.trunc() };
    let piece = own as i64;
    let on = held.unwrap_or(piece);
    by[0] = 0.0;
    Switched {
        // Beyond the range of whole numbers, and where x is no number, its own value.
        value: if on == piece || own.is_nan() {
            own
        } else {
            on as f64
        },
        seen: seen(piece, held, beyond_whole(nearest, x, on as f64)),
    }
}

/// MOD(a, b) on the piece it is held on: the whole part of a/b.
pub(super) fn modulo_on(a: f64, b: f64, held: Piece, by: &mut [f64]) -> Switched {
    let quotient = a / b;
    let piece = quotient.trunc() as i64;
    let on = held.unwrap_or(piece);
    let whole = on as f64;
    by.copy_from_slice(&[1.0, -whole]);
    Switched {
        // Its own value has no round-off, and none where b is zero.
        value: if on == piece { a % b } else { a - b * whole },
        seen: seen(piece, held, beyond_whole(false, quotient, whole)),
    }
}

/// How far x is beyond the numbers that a whole one stands for.
fn beyond_whole(nearest: bool, x: f64, whole: f64) -> f64 {
    let (below, above) = match (nearest, whole) {
        (true, _) => (0.5, 0.5),
        (false, whole) if whole > 0.0 => (0.0, 1.0),
        (false, whole) if whole < 0.0 => (1.0, 0.0),
        (false, _) => (1.0, 1.0),
    };
    let (lower, upper) = (whole - below, whole + above);
    (lower - x - rounding(lower, x)).max(x - upper - rounding(upper, x))
}

/// MAX, or MIN, on the piece it is held on: which of its arguments it is.
pub(super) fn extreme_on(largest: bool, a: &[f64], held: Piece, by: &mut [f64]) -> Switched {
    extreme(largest, a, by);
    let piece = by.iter().position(|partial| *partial != 0.0).unwrap_or(0);
    let on = held.map_or(piece, |held| held as usize);
    by.fill(0.0);
    by[on] = 1.0;
    let others = a.iter().enumerate().filter(|(k, _)| *k != on);
    let beyond = others.map(|(_, other)| {
        let more = if largest {
            other - a[on]
        } else {
            a[on] - other
        };
        more - rounding(*other, a[on])
    });
    let excess = beyond.fold(f64::NEG_INFINITY, f64::max);
    Switched {
        value: a[on],
        seen: seen(piece as i64, held, excess),
    }
}

/// Arguments that are equal but for round-off change no side.
fn rounding(a: f64, b: f64) -> f64 {
    4.0 * f64::EPSILON * a.abs().max(b.abs())
}
