use nalgebra::{DMatrix, DVector};

/// Linear least-squares regression of a result on all varied parameters, accumulated over the cases.
#[derive(Clone, Debug)]
pub(crate) struct Regression {
    /// Sums of products of the standardised parameters: a square matrix with a constant 1 as the first regressor.
    products: DMatrix<f64>,
    /// Sums of products of the regressors with the result. The first regressor is the constant 1.
    with_answer: DVector<f64>,
    /// Sum of squares of the result.
    answer: f64,
    count: u64,
}

/// Slope of the result with respect to one parameter.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Slope {
    /// Change of the result per standard deviation of the parameter.
    pub slope: f64,
    /// Standard error of the slope.
    pub error: f64,
}

impl Regression {
    /// Creates an empty regression on `numbers` parameters.
    pub(crate) fn new(numbers: usize) -> Self {
        Self {
            products: DMatrix::zeros(numbers + 1, numbers + 1),
            with_answer: DVector::zeros(numbers + 1),
            answer: 0.0,
            count: 0,
        }
    }

    /// Adds a case, with standardised parameters and with the result minus its mean.
    pub(crate) fn add(&mut self, numbers: &[f64], answer: f64) {
        let at = |k: usize| if k == 0 { 1.0 } else { numbers[k - 1] };
        for i in 0..=numbers.len() {
            for j in 0..=i {
                self.products[(i, j)] += at(i) * at(j);
            }
            self.with_answer[i] += at(i) * answer;
        }
        self.answer += answer * answer;
        self.count += 1;
    }

    /// Returns the slopes, and the share of the result's variance that the linear model explains. `None` with too few cases, or if the
    /// parameters are collinear.
    pub(crate) fn slopes(&self) -> Option<(Vec<Slope>, f64)> {
        let n = self.with_answer.len();
        let free = self.count.checked_sub(n as u64).filter(|free| *free > 0)?;
        let mut full = self.products.clone();
        full.fill_upper_triangle_with_lower_triangle();
        let inverse = full.cholesky()?.inverse();
        if inverse.iter().any(|x| !x.is_finite()) || inverse.diagonal().max() > 1e8 {
            return None;
        }
        let found = &inverse * &self.with_answer;
        let mean = self.with_answer[0] / self.count as f64;
        let total = self.answer - mean * mean * self.count as f64;
        let left = (self.answer - found.dot(&self.with_answer)).max(0.0);
        let variance = left / free as f64;
        let slopes = (1..n)
            .map(|k| Slope {
                slope: found[k],
                error: (variance * inverse[(k, k)]).sqrt(),
            })
            .collect();
        let explained = if total > 0.0 { 1.0 - left / total } else { 0.0 };
        Some((slopes, explained))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    #[test]
    fn slopes_and_their_errors_are_those_of_the_planted_line() {
        // The planted line is y = 3 a - 2 b plus noise of standard deviation 0.5. With unit variance of a and b, the standard errors are
        // 0.5/sqrt(n).
        let streams = ["a", "b", "noise"].map(|name| Stream::named(1, name));
        let normal = |k: usize, case: u64| super::super::normal::quantile(streams[k].uniform(case));
        let n = 4000;
        let mut regression = Regression::new(2);
        for case in 0..n {
            let (a, b, e) = (normal(0, case), normal(1, case), normal(2, case));
            regression.add(&[a, b], 3.0 * a - 2.0 * b + 0.5 * e);
        }
        let (slopes, explained) = regression.slopes().unwrap();
        let expected_error = 0.5 / f64::from(n as u32).sqrt();
        for (slope, planted) in slopes.iter().zip([3.0, -2.0]) {
            assert!((slope.error / expected_error - 1.0).abs() < 0.1);
            assert!((slope.slope - planted).abs() < 4.0 * slope.error);
        }
        // Explained variance: 13 of 13.25.
        assert!((explained - 13.0 / 13.25).abs() < 0.003);
        assert!(Regression::new(3).slopes().is_none());
    }
}
