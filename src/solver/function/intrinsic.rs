/// FORTRAN function of one argument.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Unary {
    Abs,
    Acos,
    Asin,
    Atan,
    Cos,
    Cosh,
    Exp,
    Ln,
    Log10,
    Nearest,
    Sin,
    Sinh,
    Sqrt,
    Tan,
    Tanh,
    Truncate,
}

impl Unary {
    /// Returns the function with this name, given in capitals.
    pub(super) fn named(name: &str) -> Option<Self> {
        Some(match name {
            "ABS" => Self::Abs,
            "ACOS" => Self::Acos,
            "ASIN" => Self::Asin,
            "ATAN" => Self::Atan,
            "COS" => Self::Cos,
            "COSH" => Self::Cosh,
            "EXP" => Self::Exp,
            "LOG" => Self::Ln,
            "LOG10" => Self::Log10,
            "ANINT" | "NINT" => Self::Nearest,
            "SIN" => Self::Sin,
            "SINH" => Self::Sinh,
            "SQRT" => Self::Sqrt,
            "TAN" => Self::Tan,
            "TANH" => Self::Tanh,
            "AINT" | "INT" => Self::Truncate,
            _ => return None,
        })
    }

    /// Returns the value and the derivative at x. A NaN value means that x lies outside the domain. The derivative is returned as zero at
    /// kinks and jumps, and as infinity at the ends of the domains of SQRT, ASIN and ACOS.
    pub(super) fn at(self, x: f64) -> (f64, f64) {
        match self {
            Self::Abs => (x.abs(), if x == 0.0 { 0.0 } else { x.signum() }),
            Self::Acos => (libm::acos(x), -1.0 / (1.0 - x * x).sqrt()),
            Self::Asin => (libm::asin(x), 1.0 / (1.0 - x * x).sqrt()),
            Self::Atan => (libm::atan(x), 1.0 / (1.0 + x * x)),
            Self::Cos => {
                let (sin, cos) = libm::sincos(x);
                (cos, -sin)
            }
            Self::Cosh => (libm::cosh(x), libm::sinh(x)),
            Self::Exp => {
                let value = libm::exp(x);
                (value, value)
            }
            Self::Ln => (libm::log(x), 1.0 / x),
            Self::Log10 => (libm::log10(x), 1.0 / (x * std::f64::consts::LN_10)),
            // Halves round away from zero, as in FORTRAN.
            Self::Nearest => (x.round(), 0.0),
            Self::Sin => libm::sincos(x),
            Self::Sinh => (libm::sinh(x), libm::cosh(x)),
            Self::Sqrt => {
                let value = x.sqrt();
                (value, 0.5 / value)
            }
            Self::Tan => {
                let value = libm::tan(x);
                (value, 1.0 + value * value)
            }
            Self::Tanh => {
                let value = libm::tanh(x);
                (value, 1.0 - value * value)
            }
            Self::Truncate => (x.trunc(), 0.0),
        }
    }
}

/// FORTRAN function of two arguments.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Binary {
    Atan2,
    Dim,
    Modulo,
    Sign,
}

impl Binary {
    /// Returns the function with this name, given in capitals.
    pub(super) fn named(name: &str) -> Option<Self> {
        Some(match name {
            "ATAN2" => Self::Atan2,
            "DIM" => Self::Dim,
            "MOD" => Self::Modulo,
            "SIGN" => Self::Sign,
            _ => return None,
        })
    }

    /// Returns the value and the derivatives with respect to a and b (guide/formats.md 3.5).
    pub(super) fn at(self, a: f64, b: f64) -> (f64, [f64; 2]) {
        match self {
            Self::Atan2 => {
                let square = a * a + b * b;
                if square == 0.0 {
                    // The value is zero at the origin, as in the C++ solver since 2016 (cfunc_atan2). Arguments whose squares underflow to
                    // zero are not the origin.
                    let value = if a == 0.0 && b == 0.0 {
                        0.0
                    } else {
                        libm::atan2(a, b)
                    };
                    return (value, [0.0, 0.0]);
                }
                (libm::atan2(a, b), [b / square, -a / square])
            }
            Self::Dim => {
                if a > b {
                    (a - b, [1.0, -1.0])
                } else {
                    (0.0, [0.0, 0.0])
                }
            }
            // Rust's `%` keeps the sign of a, as FORTRAN's MOD does, and is exact.
            Self::Modulo => (a % b, [1.0, -(a / b).trunc()]),
            Self::Sign => {
                let sign = if b < 0.0 { -1.0 } else { 1.0 };
                let slope = if a < 0.0 { -sign } else { sign };
                (a.abs() * sign, [slope, 0.0])
            }
        }
    }
}

/// Exponents for which the power is computed by multiplication.
const PRODUCTS: [f64; 4] = [2.0, 3.0, 4.0, 5.0];

/// Returns `x ** y` and its derivatives with respect to x and y. Negative x with integer y is defined. Undefined values and derivatives are
/// not finite. The exception is the derivative with respect to y, which is zero for x <= 0, because only integer y make sense there.
pub(super) fn power(x: f64, y: f64) -> (f64, [f64; 2]) {
    let (value, by_x) = if PRODUCTS.contains(&y) {
        // Small integer exponents are common in rubber laws. Multiplication is many times faster than `pow`.
        let before = (1..y as u32 - 1).fold(x, |product, _| product * x);
        (before * x, y * before)
    } else {
        let by_x = if y == 0.0 {
            0.0
        } else {
            y * libm::pow(x, y - 1.0)
        };
        (libm::pow(x, y), by_x)
    };
    let by_y = if x > 0.0 { value * libm::log(x) } else { 0.0 };
    (value, [by_x, by_y])
}

/// Returns the largest or smallest of several values. Only the selected argument (the first among equals) has a nonzero derivative.
pub(super) fn extreme(largest: bool, a: &[f64], by: &mut [f64]) -> f64 {
    let mut chosen = 0;
    for k in 1..a.len() {
        if if largest {
            a[k] > a[chosen]
        } else {
            a[k] < a[chosen]
        } {
            chosen = k;
        }
    }
    by.fill(0.0);
    by[chosen] = 1.0;
    a[chosen]
}
