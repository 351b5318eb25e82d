//! Pieces of functions that are not smooth: on which one a motion is, and how far it is from the end of it.
//!
//! A step of an integrator is smooth only if every function stays on one formula in it. So a motion holds each IMPACT, BISTOP and IF on the
//! piece it began with, beyond its end too, and looks after each step whether that end was passed.

use super::Fault;
use super::impact::Stop;

/// The piece that a function is held on; none: that of its arguments.
pub(crate) type Piece = Option<u8>;

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

/// IF: negative, zero, positive.
const NEGATIVE: u8 = 0;
const ZERO: u8 = 1;
const POSITIVE: u8 = 2;

/// The part of an IF: that of the sign of its test, or the one it is held on.
pub(super) fn part_of(test: f64, held: Piece) -> (u8, Seen) {
    let piece = match test {
        test if test < 0.0 => NEGATIVE,
        test if test > 0.0 => POSITIVE,
        _ => ZERO,
    };
    let excess = match held {
        Some(NEGATIVE) => test,
        Some(POSITIVE) => -test,
        Some(_) => test.abs(),
        None => f64::NEG_INFINITY,
    };
    let seen = Seen {
        piece: Some(piece),
        excess,
    };
    (held.unwrap_or(piece), seen)
}

/// IMPACT and BISTOP: no contact, pressed against the lower stop, in it without a force (the damping would pull), the same of the upper.
const APART: u8 = 0;
const PRESSED: [u8; 2] = [1, 3];
const LEAVING: [u8; 2] = [2, 4];

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
    let seen = Seen {
        piece: Some(piece),
        excess: held.map_or(f64::NEG_INFINITY, |_| excess),
    };
    Ok(Switched { value, seen })
}
