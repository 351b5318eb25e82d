use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use nalgebra::Complex;

/// Number type of matrices, factors and right sides: real, complex, or several numbers side by side.
pub(crate) trait Scalar:
    Copy
    + Debug
    + Default
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    const ONE: Self;

    /// Returns the magnitude by which pivots are compared; NaN if the number is NaN.
    fn size(self) -> f64;

    /// Returns the magnitude by which multipliers are bounded. For several numbers stored side by side, it is the largest of their magnitudes.
    #[inline]
    fn reach(self) -> f64 {
        self.size()
    }

    fn inverse(self) -> Self;

    fn of(real: f64) -> Self;
}

impl Scalar for f64 {
    const ONE: Self = 1.0;

    #[inline]
    fn size(self) -> f64 {
        self.abs()
    }

    #[inline]
    fn inverse(self) -> Self {
        1.0 / self
    }

    #[inline]
    fn of(real: f64) -> Self {
        real
    }
}

impl Scalar for Complex<f64> {
    const ONE: Self = Complex::new(1.0, 0.0);

    #[inline]
    fn size(self) -> f64 {
        self.re.abs() + self.im.abs()
    }

    #[inline]
    fn inverse(self) -> Self {
        self.inv()
    }

    #[inline]
    fn of(real: f64) -> Self {
        Complex::new(real, 0.0)
    }
}
