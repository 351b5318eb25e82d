//! Several numbers that go through the same operations side by side.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use super::scalar::Scalar;

/// How many.
pub(crate) const WIDTH: usize = 8;

/// One number of each of [`WIDTH`] right sides.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(crate) struct Lanes(pub [f64; WIDTH]);

impl Lanes {
    #[inline]
    fn with(mut self, other: &Self, operation: impl Fn(&mut f64, f64)) -> Self {
        for (own, other) in self.0.iter_mut().zip(&other.0) {
            operation(own, *other);
        }
        self
    }

    #[inline]
    fn each(mut self, operation: impl Fn(&mut f64)) -> Self {
        self.0.iter_mut().for_each(operation);
        self
    }
}

impl Add for Lanes {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        self.with(&other, |a, b| *a += b)
    }
}

impl Sub for Lanes {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self.with(&other, |a, b| *a -= b)
    }
}

impl Mul for Lanes {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        self.with(&other, |a, b| *a *= b)
    }
}

impl Div for Lanes {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        self.with(&other, |a, b| *a /= b)
    }
}

impl Mul<f64> for Lanes {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f64) -> Self {
        self.each(|a| *a *= factor)
    }
}

impl Div<f64> for Lanes {
    type Output = Self;

    #[inline]
    fn div(self, divisor: f64) -> Self {
        self.each(|a| *a /= divisor)
    }
}

impl Neg for Lanes {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        self.each(|a| *a = -*a)
    }
}

impl AddAssign for Lanes {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Lanes {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Scalar for Lanes {
    const ONE: Self = Self([1.0; WIDTH]);

    fn size(self) -> f64 {
        self.0.iter().fold(0.0, |most: f64, x| {
            if x.is_nan() || most.is_nan() {
                f64::NAN
            } else {
                most.max(x.abs())
            }
        })
    }

    fn inverse(self) -> Self {
        Self::ONE / self
    }

    fn of(real: f64) -> Self {
        Self([real; WIDTH])
    }
}
