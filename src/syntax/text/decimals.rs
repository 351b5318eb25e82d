/// Number of decimal places with which a quantity is printed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Decimals(usize);

impl Decimals {
    /// Returns the number of decimal places that shows two significant digits of the given error.
    ///
    /// The result is at least three, which suffices for millimetres and degrees in suspension measurements, and at most twelve.
    pub fn of_error(error: f64) -> Self {
        let digits = 1.0 - libm::log10(error.abs()).floor();
        Self(if digits.is_finite() {
            digits.clamp(3.0, 12.0) as usize
        } else {
            3
        })
    }

    /// Returns a format with one more decimal place.
    #[must_use]
    pub fn finer(self) -> Self {
        Self(self.0 + 1)
    }

    /// Formats a value with this number of decimal places.
    pub fn format(self, value: f64) -> String {
        format!("{value:.*}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::Decimals;

    #[test]
    fn two_digits_of_the_error_are_seen_in_any_unit() {
        let told = |error: f64, value: f64| Decimals::of_error(error).format(value);
        assert_eq!(told(0.05, 0.1364), "0.136");
        assert_eq!(told(0.05e-3, 0.1364e-3), "0.000136");
        assert_eq!(told(2.0, 1.3), "1.300");
        assert_eq!(told(0.0, 1.3), "1.300");
        assert_eq!(Decimals::of_error(0.05).finer().format(0.05), "0.0500");
    }
}
