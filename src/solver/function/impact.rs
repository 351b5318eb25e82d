use super::Fault;
use super::step::{Shape, step};

/// Evaluates IMPACT(x, xdot, x1, k, e, cmax, d) with partial derivatives (guide/formats.md 3.6).
///
/// ```text
/// x < x1:  max(0, k (x1 - x)^e - STEP(x, x1 - d, cmax, x1, 0) xdot),  else 0
/// ```
/// d = 0 is the limit of small d: full damping from the first contact.
pub(super) fn impact(a: &[f64], by: &mut [f64]) -> Result<f64, Fault> {
    let &[x, xdot, x1, k, e, cmax, d] = a else {
        unreachable!("the grammar gives IMPACT seven arguments");
    };
    by.fill(0.0);
    let p = x1 - x;
    if p <= 0.0 {
        return Ok(0.0);
    }
    let stop = Stop::at(p, xdot, k, e, cmax, d)?;
    if stop.force <= 0.0 {
        return Ok(0.0);
    }
    by[0] = -stop.by_p;
    by[1] = stop.by_rate;
    by[2] = stop.by_p;
    by[3..7].copy_from_slice(&stop.by_law);
    Ok(stop.force)
}

/// Evaluates BISTOP(x, xdot, x1, x2, k, e, cmax, d) with partial derivatives (guide/formats.md 3.6).
///
/// ```text
/// x < x1:        max(0,  k (x1 - x)^e - STEP(x, x1 - d, cmax, x1, 0) xdot)
/// x > x2:        min(0, -k (x - x2)^e - STEP(x, x2, 0, x2 + d, cmax) xdot)
/// x1 <= x <= x2: 0
/// ```
pub(super) fn bistop(a: &[f64], by: &mut [f64]) -> Result<f64, Fault> {
    let &[x, xdot, x1, x2, k, e, cmax, d] = a else {
        unreachable!("the grammar gives BISTOP eight arguments");
    };
    by.fill(0.0);
    // The upper stop is the mirror image of the lower one: x, xdot and the force change sign.
    let (p, rate, sign, bound) = if x < x1 {
        (x1 - x, xdot, 1.0, 2)
    } else if x > x2 {
        (x - x2, -xdot, -1.0, 3)
    } else {
        return Ok(0.0);
    };
    let stop = Stop::at(p, rate, k, e, cmax, d)?;
    if stop.force <= 0.0 {
        return Ok(0.0);
    }
    // Lower stop: p = x1 - x, F = f. Upper stop: p = x - x2, F = -f. In both cases, dF/dx = -df/dp and dF/dxdot = df/drate.
    by[0] = -stop.by_p;
    by[1] = stop.by_rate;
    by[bound] = stop.by_p;
    for (out, law) in by[4..8].iter_mut().zip(stop.by_law) {
        *out = sign * law;
    }
    Ok(sign * stop.force)
}

/// Contact force `k p^e - c(p) rate` at a penetration p, where c grows from 0 at p = 0 to cmax at p = d. For p < 0, `p^e` is continued as
/// an odd function, or as 1 if e = 0.
pub(super) struct Stop {
    pub force: f64,
    pub by_p: f64,
    pub by_rate: f64,
    /// Derivatives with respect to k, e, cmax, d.
    pub by_law: [f64; 4],
}

impl Stop {
    pub(super) fn at(p: f64, rate: f64, k: f64, e: f64, cmax: f64, d: f64) -> Result<Self, Fault> {
        let (power, slope) = if e == 0.0 {
            (1.0, 0.0)
        } else {
            let power = libm::copysign(libm::pow(p.abs(), e), p);
            (power, e * libm::pow(p.abs(), e - 1.0))
        };
        let mut by = [0.0; 5];
        let c = if d == 0.0 {
            by[4] = 1.0;
            cmax
        } else {
            step(Shape::Cubic, &[p, 0.0, 0.0, d, cmax], &mut by)?
        };
        Ok(Self {
            force: k * power - c * rate,
            by_p: k * slope - by[0] * rate,
            by_rate: -c,
            by_law: [
                power,
                k * power * libm::log(p.abs()),
                -by[4] * rate,
                -by[3] * rate,
            ],
        })
    }
}
