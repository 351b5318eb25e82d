//! Numbers from several right sides that undergo the same operations side by side.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use super::scalar::Scalar;

/// One number from each of N right sides.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Lanes<const N: usize>(pub [f64; N]);

impl<const N: usize> Default for Lanes<N> {
    fn default() -> Self {
        Self([0.0; N])
    }
}

impl<const N: usize> Lanes<N> {
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

impl<const N: usize> Add for Lanes<N> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        self.with(&other, |a, b| *a += b)
    }
}

impl<const N: usize> Sub for Lanes<N> {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self.with(&other, |a, b| *a -= b)
    }
}

impl<const N: usize> Mul for Lanes<N> {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        self.with(&other, |a, b| *a *= b)
    }
}

impl<const N: usize> Div for Lanes<N> {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        self.with(&other, |a, b| *a /= b)
    }
}

impl<const N: usize> Mul<f64> for Lanes<N> {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f64) -> Self {
        self.each(|a| *a *= factor)
    }
}

impl<const N: usize> Div<f64> for Lanes<N> {
    type Output = Self;

    #[inline]
    fn div(self, divisor: f64) -> Self {
        self.each(|a| *a /= divisor)
    }
}

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        self.each(|a| *a = -*a)
    }
}

impl<const N: usize> AddAssign for Lanes<N> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> SubAssign for Lanes<N> {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const N: usize> Scalar for Lanes<N> {
    const ONE: Self = Self([1.0; N]);

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
        Self([real; N])
    }
}
