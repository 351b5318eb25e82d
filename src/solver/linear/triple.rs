//! A real and a complex number that undergo the same operations side by side.
//!
//! The real and the complex matrix of an integration step have the same pattern and similar magnitudes. Factored side by side, they share one
//! elimination order, and its index lists are read once for both.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use nalgebra::Complex;

use super::scalar::Scalar;

/// A real number and a complex number.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(crate) struct Triple {
    pub alone: f64,
    pub pair: Complex<f64>,
}

impl Triple {
    #[inline]
    pub(crate) fn new(alone: f64, pair: Complex<f64>) -> Self {
        Self { alone, pair }
    }

    /// Combines the magnitudes of both numbers by `chosen`. Returns NaN if either number is NaN.
    #[inline]
    fn sizes(self, chosen: impl Fn(f64, f64) -> f64) -> f64 {
        let (alone, pair) = (self.alone.size(), self.pair.size());
        if alone.is_nan() || pair.is_nan() {
            f64::NAN
        } else {
            chosen(alone, pair)
        }
    }
}

impl Add for Triple {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self::new(self.alone + other.alone, self.pair + other.pair)
    }
}

impl Sub for Triple {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::new(self.alone - other.alone, self.pair - other.pair)
    }
}

impl Mul for Triple {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        Self::new(self.alone * other.alone, self.pair * other.pair)
    }
}

impl Div for Triple {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        Self::new(self.alone / other.alone, self.pair / other.pair)
    }
}

impl Mul<f64> for Triple {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self::new(self.alone * factor, self.pair * factor)
    }
}

impl Div<f64> for Triple {
    type Output = Self;

    #[inline]
    fn div(self, divisor: f64) -> Self {
        Self::new(self.alone / divisor, self.pair / divisor)
    }
}

/// Multiplies a real number by the real number of a triple and ignores the complex number.
impl Mul<Triple> for f64 {
    type Output = f64;

    #[inline]
    fn mul(self, factor: Triple) -> f64 {
        self * factor.alone
    }
}

impl Div<Triple> for f64 {
    type Output = f64;

    #[inline]
    fn div(self, divisor: Triple) -> f64 {
        self / divisor.alone
    }
}

impl Neg for Triple {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self::new(-self.alone, -self.pair)
    }
}

impl AddAssign for Triple {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Triple {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Scalar for Triple {
    const ONE: Self = Self {
        alone: 1.0,
        pair: Complex::new(1.0, 0.0),
    };

    /// Returns the smaller of the two magnitudes, because a pivot must serve both matrices.
    #[inline]
    fn size(self) -> f64 {
        self.sizes(f64::min)
    }

    #[inline]
    fn reach(self) -> f64 {
        self.sizes(f64::max)
    }

    #[inline]
    fn inverse(self) -> Self {
        Self::new(self.alone.inverse(), self.pair.inverse())
    }

    #[inline]
    fn of(real: f64) -> Self {
        Self::new(real, Complex::new(real, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::{Entries, Lu};

    /// Checks that both matrices give the same solutions as when factored separately, in a first and in a repeated factorisation. A real right
    /// side gives the solution of the real matrix.
    #[test]
    fn side_by_side_is_as_alone() {
        let n = 5;
        let places: Vec<(u32, u32)> = (0..n as u32)
            .flat_map(|column| (0..n as u32).map(move |row| (column, row)))
            .filter(|(column, row)| column.abs_diff(*row) < 3)
            .collect();
        let (mut both, mut one, mut two) = (Lu::new(n), Lu::new(n), Lu::new(n));
        for round in 0..2 {
            let number = |k: usize| libm::sin(1.0 + (7 * k + 3 * round) as f64);
            let of_pair = |k: usize| Complex::new(number(k + 40), number(k + 90));
            let count = 0..places.len();
            let values: Vec<Triple> = count.map(|k| Triple::new(number(k), of_pair(k))).collect();
            let alone: Vec<f64> = values.iter().map(|v| v.alone).collect();
            let pair: Vec<Complex<f64>> = values.iter().map(|v| v.pair).collect();
            let places = &places[..];
            let values = &values[..];
            both.factor_entries(&Entries::whole(n, places, values));
            let values = &alone[..];
            one.factor_entries(&Entries::whole(n, places, values));
            let values = &pair[..];
            two.factor_entries(&Entries::whole(n, places, values));
            let mut b: Vec<Triple> = (0..n)
                .map(|k| Triple::new(number(k + 5), of_pair(k + 9)))
                .collect();
            let mut x: Vec<f64> = b.iter().map(|b| b.alone).collect();
            let mut y: Vec<Complex<f64>> = b.iter().map(|b| b.pair).collect();
            let (mut real, mut found) = (x.clone(), x.clone());
            both.solve(&mut b);
            both.solve_into(&mut real, &mut found);
            one.solve(&mut x);
            two.solve(&mut y);
            for k in 0..n {
                let off = (b[k].alone - x[k]).abs() + (b[k].pair - y[k]).norm();
                assert!(off < 1e-12, "{off:e}");
                assert!((found[k] - x[k]).abs() < 1e-12);
            }
        }
    }
}
