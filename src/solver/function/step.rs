use super::Fault;

/// Shape of a step between two levels.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Shape {
    /// STEP: `u^2 (3 - 2u)`.
    Cubic,
    /// STEP5: `u^3 (10 - 15u + 6u^2)`.
    Quintic,
    /// HAVSIN: `(1 + sin(pi u - pi/2)) / 2`.
    Haversine,
}

impl Shape {
    /// Returns the shape function s(u), which rises from 0 to 1, and its derivative for u in [0, 1].
    pub(super) fn at(self, u: f64) -> (f64, f64) {
        match self {
            Self::Cubic => (u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u)),
            Self::Quintic => (
                u * u * u * (10.0 + u * (6.0 * u - 15.0)),
                30.0 * u * u * (1.0 - u) * (1.0 - u),
            ),
            Self::Haversine => {
                let (sin, cos) = libm::sincos(std::f64::consts::PI * (u - 0.5));
                (0.5 * (1.0 + sin), 0.5 * std::f64::consts::PI * cos)
            }
        }
    }

    /// Returns the second derivative of the shape function s(u) for u in [0, 1].
    pub(super) fn second(self, u: f64) -> f64 {
        use std::f64::consts::PI;
        match self {
            Self::Cubic => 6.0 - 12.0 * u,
            Self::Quintic => 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u),
            Self::Haversine => -0.5 * PI * PI * libm::sin(PI * (u - 0.5)),
        }
    }
}

/// Evaluates STEP, STEP5 or HAVSIN of (x, x0, h0, x1, h1) with partial derivatives with respect to the five arguments (guide/formats.md
/// 3.6).
///
/// x0 > x1 gives the mirrored step. Equal ends are an error.
pub(super) fn step(shape: Shape, a: &[f64], by: &mut [f64]) -> Result<f64, Fault> {
    let &[x, x0, h0, x1, h1] = a else {
        unreachable!("the grammar gives steps five arguments");
    };
    let width = x1 - x0;
    if width == 0.0 {
        return Err(Fault::EqualEnds);
    }
    let u = (x - x0) / width;
    // At and beyond the ends, the level is returned exactly.
    let (s, slope) = if u <= 0.0 {
        (0.0, 0.0)
    } else if u >= 1.0 {
        (1.0, 0.0)
    } else {
        shape.at(u)
    };
    let rate = (h1 - h0) * slope / width;
    by[0] = rate;
    by[1] = rate * (u - 1.0);
    by[2] = 1.0 - s;
    by[3] = -rate * u;
    by[4] = s;
    Ok(if s == 1.0 { h1 } else { h0 + (h1 - h0) * s })
}
