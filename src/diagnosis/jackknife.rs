//! Reduction of an rms error between two models, with a standard error from a jackknife over groups of readings.
//!
//! Source: Efron and Tibshirani, An Introduction to the Bootstrap (1993), chapter 11.

/// Sums of squared errors of two models over one group of readings that share their errors.
#[derive(Clone, Copy, Default, Debug)]
pub(super) struct Squares {
    /// Sum of squared errors of the first model.
    pub before: f64,
    /// Sum of squared errors of the second model.
    pub after: f64,
    /// Number of readings in the group.
    pub count: f64,
}

/// Rms errors of two models, and the standard error of their difference.
#[derive(Clone, Copy, Debug)]
pub(super) struct RmsReduction {
    /// Rms error of the first model.
    pub before: f64,
    /// Rms error of the second model.
    pub after: f64,
    /// Standard error of `before - after`. NaN with a single group.
    pub std_error: f64,
}

/// Returns the rms errors of both models over all groups, and the standard error of their difference. Returns `None` for an empty list.
pub(super) fn rms_reduction(groups: &[Squares]) -> Option<RmsReduction> {
    let total = |without: Option<usize>| {
        let mut sum = Squares::default();
        for (_, own) in groups
            .iter()
            .enumerate()
            .filter(|(k, _)| Some(*k) != without)
        {
            sum.before += own.before;
            sum.after += own.after;
            sum.count += own.count;
        }
        [sum.before, sum.after].map(|squares| (squares / sum.count).sqrt())
    };
    if groups.is_empty() {
        return None;
    }
    let n = groups.len() as f64;
    let falls: Vec<f64> = (0..groups.len())
        .map(|k| {
            let [before, after] = total(Some(k));
            before - after
        })
        .collect();
    let mean = falls.iter().sum::<f64>() / n;
    let spread: f64 = falls.iter().map(|fall| (fall - mean).powi(2)).sum();
    let [before, after] = total(None);
    Some(RmsReduction {
        before,
        after,
        std_error: if groups.len() > 1 {
            (spread * (n - 1.0) / n).sqrt()
        } else {
            f64::NAN
        },
    })
}

#[cfg(test)]
mod tests {
    use super::{Squares, rms_reduction};

    /// With one reading per group, the jackknife gives the standard error of the mean.
    #[test]
    fn the_error_is_that_of_the_mean_where_the_rms_is_one() {
        // The rms is linear for small differences: sqrt(1 + d) is 1 + d/2.
        let d = [1e-5, -2e-5, 4e-5, 3e-5, -1e-5];
        let groups = d.map(|d| Squares {
            before: 1.0 + d,
            after: 1.0,
            count: 1.0,
        });
        let fall = rms_reduction(&groups).unwrap();
        let mean = d.iter().sum::<f64>() / 5.0;
        let variance: f64 = d.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 20.0;
        assert!((fall.before - fall.after - 0.5 * mean).abs() < 1e-9);
        assert!((fall.std_error / (0.5 * variance.sqrt()) - 1.0).abs() < 1e-3);
    }
}
