//! Comparisons that propagate NaN, which `f64::max` does not.

/// Returns the larger of two numbers, or NaN if either is NaN.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if exceeds(b, a) { b } else { a }
}

/// Returns true if `value` is larger than `most` or is NaN. If `most` is NaN, the result is true only for a NaN `value`.
pub(crate) fn exceeds(value: f64, most: f64) -> bool {
    value > most || value.is_nan()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nan_stays_whatever_follows() {
        for numbers in [
            [1.0, f64::NAN, 3.0],
            [f64::NAN, 1.0, 2.0],
            [1.0, 2.0, f64::NAN],
        ] {
            assert!(numbers.into_iter().fold(0.0, larger).is_nan());
        }
        assert_eq!([1.0, 3.0, 2.0].into_iter().fold(0.0, larger), 3.0);
    }
}
