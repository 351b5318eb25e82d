use super::Fault;
use super::step::{Shape, step};

/// Evaluates POLY(x, x0, a0, ..., an) = `sum a_j (x - x0)^j` with partial derivatives.
pub(super) fn poly(a: &[f64], by: &mut [f64]) -> f64 {
    let u = a[0] - a[1];
    let (mut value, mut slope) = (0.0, 0.0);
    for &coefficient in a[2..].iter().rev() {
        slope = slope * u + value;
        value = value * u + coefficient;
    }
    let mut power = 1.0;
    for out in &mut by[2..] {
        *out = power;
        power *= u;
    }
    by[0] = slope;
    by[1] = -slope;
    value
}

/// Returns the second derivative of [`poly`] with respect to x: `sum j (j - 1) a_j (x - x0)^(j-2)`.
pub(super) fn poly_second(a: &[f64]) -> f64 {
    let u = a[0] - a[1];
    let terms = a[2..].iter().enumerate().skip(2).rev();
    terms.fold(0.0, |sum, (j, a)| sum * u + (j * (j - 1)) as f64 * a)
}

/// Evaluates CHEBY(x, x0, a0, ..., an) = `sum a_j T_j(x - x0)` with partial derivatives. `T_0 = 1, T_1 = u, T_j = 2 u T_(j-1) - T_(j-2)`.
pub(super) fn cheby(a: &[f64], by: &mut [f64]) -> f64 {
    let u = a[0] - a[1];
    let (mut value, mut slope) = (0.0, 0.0);
    // Pairs (T_j, T_j') for the current j and for j + 1.
    let (mut t, mut dt) = ((1.0, 0.0), (u, 1.0));
    for (&coefficient, out) in a[2..].iter().zip(&mut by[2..]) {
        *out = t.0;
        value += coefficient * t.0;
        slope += coefficient * t.1;
        let next = (2.0 * u * dt.0 - t.0, 2.0 * dt.0 + 2.0 * u * dt.1 - t.1);
        t = dt;
        dt = next;
    }
    by[0] = slope;
    by[1] = -slope;
    value
}

/// Returns the second derivative of [`cheby`] with respect to x, using `T_j'' = 4 T_(j-1)' + 2 u T_(j-1)'' - T_(j-2)''`.
pub(super) fn cheby_second(a: &[f64]) -> f64 {
    let u = a[0] - a[1];
    // Triples (T_j, T_j', T_j'') for the current j and for j + 1.
    let (mut t, mut next) = ([1.0, 0.0, 0.0], [u, 1.0, 0.0]);
    let mut sum = 0.0;
    for &coefficient in &a[2..] {
        sum += coefficient * t[2];
        let after = [
            2.0 * u * next[0] - t[0],
            2.0 * next[0] + 2.0 * u * next[1] - t[1],
            4.0 * next[1] + 2.0 * u * next[2] - t[2],
        ];
        (t, next) = (next, after);
    }
    sum
}

/// Evaluates FORCOS(x, x0, w, a0, ..., an) = `a0 + sum_(j>0) a_j cos(j w (x - x0))` with partial derivatives. FORSIN uses sin instead; a0
/// is a constant term in both.
pub(super) fn fourier(sine: bool, a: &[f64], by: &mut [f64]) -> f64 {
    let (u, w) = (a[0] - a[1], a[2]);
    let (mut value, mut by_phase) = (a[3], 0.0);
    by[3] = 1.0;
    for (j, &coefficient) in a.iter().enumerate().skip(4) {
        let order = (j - 3) as f64;
        let (sin, cos) = libm::sincos(order * w * u);
        let (term, slope) = if sine { (sin, cos) } else { (cos, -sin) };
        value += coefficient * term;
        by_phase += coefficient * order * slope;
        by[j] = term;
    }
    by[0] = w * by_phase;
    by[1] = -w * by_phase;
    by[2] = u * by_phase;
    value
}

/// Returns the second derivative of [`fourier`] with respect to x: `-w^2 sum_(j>0) j^2 a_j cos(j w (x - x0))`. For FORSIN, sin replaces
/// cos.
pub(super) fn fourier_second(sine: bool, a: &[f64]) -> f64 {
    let (u, w) = (a[0] - a[1], a[2]);
    let terms = a.iter().enumerate().skip(4).map(|(j, coefficient)| {
        let order = (j - 3) as f64;
        let (sin, cos) = libm::sincos(order * w * u);
        coefficient * order * order * if sine { sin } else { cos }
    });
    -w * w * terms.sum::<f64>()
}

/// Evaluates SHF(x, x0, a, w, phi[, b]) = `a sin(w (x - x0) - phi) + b` with partial derivatives.
pub(super) fn shf(a: &[f64], by: &mut [f64]) -> f64 {
    let (u, amplitude, w, phi) = (a[0] - a[1], a[2], a[3], a[4]);
    let (sin, cos) = libm::sincos(w * u - phi);
    by[0] = amplitude * w * cos;
    by[1] = -by[0];
    by[2] = sin;
    by[3] = amplitude * u * cos;
    by[4] = -amplitude * cos;
    if let Some(bias) = by.get_mut(5) {
        *bias = 1.0;
    }
    amplitude * sin + a.get(5).copied().unwrap_or(0.0)
}

/// Evaluates SWEEP(x, a, x0, f0, x1, f1, dx) with partial derivatives: a sine of amplitude a with a smooth start from x0 to x0 + dx. Its
/// instantaneous frequency varies linearly from f0 at x0 to f1 at x1.
///
/// ```text
/// STEP5(x, x0, 0, x0 + dx, 1) a sin(2 pi h(x))
/// x <= x0: h = f0 x;  x0 < x < x1: h = f0 x + (f1 - f0) (x - x0)^2 / (2 (x1 - x0));  x >= x1: h = f1 x - (f1 - f0) (x1 + x0) / 2
/// ```
pub(super) fn sweep(args: &[f64], by: &mut [f64]) -> Result<f64, Fault> {
    let &[x, a, x0, f0, x1, f1, dx] = args else {
        unreachable!("the grammar gives SWEEP seven arguments");
    };
    let width = x1 - x0;
    if width == 0.0 {
        return Err(Fault::EqualEnds);
    }
    let mut by_step = [0.0; 5];
    let envelope = if dx == 0.0 {
        f64::from(u8::from(x > x0))
    } else {
        step(Shape::Quintic, &[x, x0, 0.0, x0 + dx, 1.0], &mut by_step)?
    };
    // h and its derivatives with respect to x, x0, f0, x1, f1.
    let u = x - x0;
    let rise = f1 - f0;
    let (h, by_h) = if x <= x0 {
        (f0 * x, [f0, 0.0, x, 0.0, 0.0])
    } else if x < x1 {
        let bend = u * u / (2.0 * width);
        (
            f0 * x + rise * bend,
            [
                f0 + rise * u / width,
                rise * (bend - u) / width,
                x - bend,
                -rise * bend / width,
                bend,
            ],
        )
    } else {
        let middle = 0.5 * (x1 + x0);
        (
            f1 * x - rise * middle,
            [f1, -0.5 * rise, middle, -0.5 * rise, x - middle],
        )
    };
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * h);
    let swing = envelope * a * std::f64::consts::TAU * cos;
    let grow = a * sin;
    by[0] = swing * by_h[0] + grow * by_step[0];
    by[1] = envelope * sin;
    // x0 shifts both ends of the start-up step.
    by[2] = swing * by_h[1] + grow * (by_step[1] + by_step[3]);
    by[3] = swing * by_h[2];
    by[4] = swing * by_h[3];
    by[5] = swing * by_h[4];
    by[6] = grow * by_step[3];
    Ok(envelope * grow)
}

/// Returns the second derivative of SWEEP with respect to x.
///
/// With the value a y, y = E sin p, the envelope E and the phase p = 2 pi h: `y'' = (E'' - E p'^2) sin p + (2 E' p' + E p'') cos p`.
pub(super) fn sweep_second(args: &[f64]) -> f64 {
    let &[x, a, x0, f0, x1, f1, dx] = args else {
        unreachable!("the grammar gives SWEEP seven arguments");
    };
    let starting = dx != 0.0 && (x - x0) / dx < 1.0;
    let (envelope, rate, bend) = match (x - x0) / dx {
        _ if !starting => (f64::from(u8::from(x > x0)), 0.0, 0.0),
        u if u <= 0.0 => (0.0, 0.0, 0.0),
        u => {
            let (value, slope) = Shape::Quintic.at(u);
            (value, slope / dx, Shape::Quintic.second(u) / (dx * dx))
        }
    };
    let tau = std::f64::consts::TAU;
    let u = x - x0;
    let (h, frequency, chirp) = if x <= x0 {
        (f0 * x, f0, 0.0)
    } else if x < x1 {
        let rise = (f1 - f0) / (x1 - x0);
        (f0 * x + 0.5 * rise * u * u, f0 + rise * u, rise)
    } else {
        (f1 * x - 0.5 * (f1 - f0) * (x1 + x0), f1, 0.0)
    };
    let (sin, cos) = libm::sincos(tau * h);
    let turn = tau * frequency;
    a * ((bend - envelope * turn * turn) * sin + (2.0 * rate * turn + envelope * tau * chirp) * cos)
}
