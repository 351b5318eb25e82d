/// Digits after the point with which numbers of one kind are told.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Decimals(usize);

impl Decimals {
    /// Two significant digits of an error; three after the point at least, which is enough for millimetres and degrees of axles.
    pub fn of_error(error: f64) -> Self {
        let digits = 1.0 - libm::log10(error.abs()).floor();
        Self(if digits.is_finite() {
            digits.clamp(3.0, 12.0) as usize
        } else {
            3
        })
    }

    /// One digit more.
    #[must_use]
    pub fn finer(self) -> Self {
        Self(self.0 + 1)
    }

    /// A number with these digits.
    pub fn told(self, value: f64) -> String {
        format!("{value:.*}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::Decimals;

    #[test]
    fn two_digits_of_the_error_are_seen_in_any_unit() {
        let told = |error: f64, value: f64| Decimals::of_error(error).told(value);
        assert_eq!(told(0.05, 0.1364), "0.136");
        assert_eq!(told(0.05e-3, 0.1364e-3), "0.000136");
        assert_eq!(told(2.0, 1.3), "1.300");
        assert_eq!(told(0.0, 1.3), "1.300");
        assert_eq!(Decimals::of_error(0.05).finer().told(0.05), "0.0500");
    }
}
