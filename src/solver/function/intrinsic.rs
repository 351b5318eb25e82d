/// A FORTRAN function of one argument.
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
    /// The function by its name in capitals.
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

    /// Value and derivative. A value that is not a number says that x lies outside of the domain. Where the derivative does not
    /// exist or is infinite (kinks, jumps, the ends of SQRT, ASIN, ACOS) it is returned as the caller finds it useful: kinks and
    /// jumps as zero, ends as infinity.
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
            // Halves go away from zero, as in FORTRAN.
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

/// A FORTRAN function of two arguments.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Binary {
    Atan2,
    Dim,
    Modulo,
    Sign,
}

impl Binary {
    /// The function by its name in capitals.
    pub(super) fn named(name: &str) -> Option<Self> {
        Some(match name {
            "ATAN2" => Self::Atan2,
            "DIM" => Self::Dim,
            "MOD" => Self::Modulo,
            "SIGN" => Self::Sign,
            _ => return None,
        })
    }

    /// Value and derivatives by a and b (guide/formats.md 3.5).
    pub(super) fn at(self, a: f64, b: f64) -> (f64, [f64; 2]) {
        match self {
            Self::Atan2 => {
                let square = a * a + b * b;
                if square == 0.0 {
                    // Zero at the origin, as the C++ solver since 2016 (cfunc_atan2); too small to be squared is no origin.
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
            // The operator keeps the sign of a, like FORTRAN's MOD; it is exact.
            Self::Modulo => (a % b, [1.0, -(a / b).trunc()]),
            Self::Sign => {
                let sign = if b < 0.0 { -1.0 } else { 1.0 };
                let slope = if a < 0.0 { -sign } else { sign };
                (a.abs() * sign, [slope, 0.0])
            }
        }
    }
}

/// Powers that are products.
const PRODUCTS: [f64; 4] = [2.0, 3.0, 4.0, 5.0];

/// `x ** y` and its derivatives. Negative x with whole y is defined; where the value or a derivative is not defined it is not a
/// finite number, except that the derivative by y is taken as zero for x <= 0, where only whole y are meant.
pub(super) fn power(x: f64, y: f64) -> (f64, [f64; 2]) {
    let (value, by_x) = if PRODUCTS.contains(&y) {
        // What laws of rubber have: many times as fast as the general case.
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

/// The largest, or smallest, of several; only the one chosen (the first of equals) has a derivative.
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
