//! Piecewise functions: the active piece (formula), and the distance of the arguments from the end of that piece.
//!
//! An integrator step is smooth only if every function keeps one formula during the step. The integrator therefore holds each piecewise
//! function on the piece active at the start of the step, even beyond the end of that piece. The functions are IMPACT, BISTOP, ABS, SIGN,
//! DIM, MAX, MIN, AINT, ANINT, MOD and IF. After each step, the integrator checks whether the end of a piece was passed (event location).

use super::Fault;
use super::impact::Stop;
use super::intrinsic::extreme;

/// Code of the piece on which a function is held; `None` selects the piece from the arguments.
pub(crate) type Piece = Option<i64>;

/// Observed state of a piecewise function after an evaluation.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct SwitchState {
    /// Piece to which the arguments belong; `None` if the function was not evaluated, as in the parts of an IF that are not selected.
    pub piece: Piece,
    /// Event function: negative on the piece on which the function is held, zero at its end, positive beyond.
    pub excess: f64,
}

impl SwitchState {
    /// State of a function that was not evaluated.
    pub(crate) const NOTHING: Self = Self {
        piece: None,
        excess: f64::NEG_INFINITY,
    };
}

/// Value of a piecewise function, with the observed state.
pub(super) struct Switched {
    pub value: f64,
    pub seen: SwitchState,
}

/// Returns the piece code of a function that is held between its two sides, where both sides push towards the switching point (sliding
/// mode). The value then varies linearly from one side to the other while the argument lies within the half width `width` of zero. The half
/// width is rounded down to a power of two. A sticking motion creeps by less than this width.
pub(crate) fn between(width: f64) -> i64 {
    (libm::log2(width).floor() as i64).clamp(-1000, -1)
}

/// Returns the half width of a function that is held between its two sides, or `None` for any other piece.
pub(crate) fn half_width(held: Piece) -> Option<f64> {
    let between = held.filter(|piece| *piece < 0)?;
    Some(libm::exp2(between as f64))
}

/// Piece code of a negative argument. IF uses all three codes, ABS and DIM only negative and positive.
const NEGATIVE: i64 = 0;
const ZERO: i64 = 1;
const POSITIVE: i64 = 2;

/// Returns the selected part of an IF and its observed state. If the IF is held on a part, that part is returned; otherwise the sign of the
/// test selects the part. An IF held between its two sides returns the negative part.
pub(super) fn part_of(test: f64, held: Piece) -> (i64, SwitchState) {
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

/// Piece code of IMPACT and BISTOP without contact.
const APART: i64 = 0;
/// Piece codes of contact with a force: first at the lower stop, then at the upper stop.
const PRESSED: [i64; 2] = [1, 3];
/// Piece codes of penetration without a force, because the damping would pull: first at the lower stop, then at the upper stop.
const LEAVING: [i64; 2] = [2, 4];

/// Evaluates IMPACT(x, xdot, x1, k, e, cmax, d) or BISTOP(x, xdot, x1, x2, k, e, cmax, d) on the piece on which it is held, with partial
/// derivatives.
///
/// A function held in contact beyond the end of its piece has a negative penetration. The spring force is then continued as an odd
/// function, and the damping is zero unless d = 0.
pub(super) fn stop_on(a: &[f64], held: Piece, by: &mut [f64]) -> Result<Switched, Fault> {
    by.fill(0.0);
    let (x, rate) = (a[0], a[1]);
    let both = a.len() == 8;
    let law = if both { 4 } else { 3 };
    let (k, e, cmax, d) = (a[law], a[law + 1], a[law + 2], a[law + 3]);
    // Penetrations into the lower and the upper stop.
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
            // On both sides, dF/dx = -df/dp and dF/dxdot = df/drate.
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

/// Returns the observed state of a function whose arguments belong to `piece`. `excess` is zero at the end of the held piece; it is ignored
/// if the function is not held.
fn seen(piece: i64, held: Piece, excess: f64) -> SwitchState {
    SwitchState {
        piece: Some(piece),
        excess: held.map_or(f64::NEG_INFINITY, |_| excess),
    }
}

/// Evaluates ABS(x) on the piece on which it is held: x or -x.
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

/// Evaluates DIM(a, b) on the piece on which it is held: a - b or zero.
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

/// Evaluates SIGN(a, b) on the piece on which it is held. The piece code is the sum of 1 if a is negative and 2 if b is negative.
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

/// Evaluates AINT(x) or ANINT(x) on the piece on which it is held. The piece code is the integer value of the function.
pub(super) fn whole_on(nearest: bool, x: f64, held: Piece, by: &mut [f64]) -> Switched {
    let own = if nearest { x.round() } else { x.trunc() };
    let piece = own as i64;
    let on = held.unwrap_or(piece);
    by[0] = 0.0;
    Switched {
        // The exact value is kept beyond the range of integers and for NaN.
        value: if on == piece || own.is_nan() {
            own
        } else {
            on as f64
        },
        seen: seen(piece, held, beyond_whole(nearest, x, on as f64)),
    }
}

/// Evaluates MOD(a, b) on the piece on which it is held. The piece code is the integer part of a/b.
pub(super) fn modulo_on(a: f64, b: f64, held: Piece, by: &mut [f64]) -> Switched {
    let quotient = a / b;
    let piece = quotient.trunc() as i64;
    let on = held.unwrap_or(piece);
    let whole = on as f64;
    by.copy_from_slice(&[1.0, -whole]);
    Switched {
        // On its own piece, the exact remainder is used: it has no round-off, and is NaN where b is zero.
        value: if on == piece { a % b } else { a - b * whole },
        seen: seen(piece, held, beyond_whole(false, quotient, whole)),
    }
}

/// Returns the distance by which x lies outside the interval of numbers that round or truncate to `whole`; negative inside.
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

/// Evaluates MAX or MIN on the piece on which it is held. The piece code is the index of the selected argument.
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

/// Returns the tolerance within which two arguments count as equal, so that round-off causes no switch.
fn rounding(a: f64, b: f64) -> f64 {
    4.0 * f64::EPSILON * a.abs().max(b.abs())
}
