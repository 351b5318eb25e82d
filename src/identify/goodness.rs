//! Chi-square test of whether the residuals of a fit exceed the noise.

use crate::settings::LACK_OF_FIT_LEVEL;
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use admire_study::Measurement;

/// Verdict of the chi-square test.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FitVerdict {
    /// The residuals agree with the stated noise.
    Noise,
    /// The residuals exceed the stated noise: the model is deficient, or the noise is understated.
    Misfit,
    /// The residuals are smaller than the stated noise: the noise is overstated, and the intervals are too wide.
    NoiseOverstated,
}

/// Residuals of one kind of reading.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ReadingsLeft {
    /// Kind of reading: `marks`, `wheel position`, `wheel angles` or the name of a channel.
    pub kind: String,
    /// Number of scalar readings.
    pub count: usize,
    /// Rms of the residuals, each divided by the standard deviation of its noise.
    pub rms_over_sigma: f64,
}

/// Chi-square test of all readings that a fit used.
///
/// The statistic is the sum of squared residuals over their variances, plus the prior terms of the other fitted errors, such as offsets and
/// frame errors. It follows the chi-square distribution. The degrees of freedom are the number of readings minus the effective number of
/// stiffnesses. A stiffness that the readings determine only in part counts as a fraction.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct FitTest {
    /// Chi-square statistic.
    pub chi2: f64,
    /// Degrees of freedom of the chi-square statistic.
    pub dof: f64,
    /// Probability of a larger statistic if the residuals contain only the stated noise.
    pub p_value: f64,
    /// Verdict of the test.
    pub verdict: FitVerdict,
    /// Residuals, one entry for each kind of reading.
    pub readings: Vec<ReadingsLeft>,
}

impl FitTest {
    /// Evaluates the test for the statistic `chi2` with `dof` degrees of freedom. Returns `None` without degrees of freedom or for a statistic
    /// that is not finite.
    pub fn new(chi2: f64, dof: f64, readings: Vec<ReadingsLeft>) -> Option<Self> {
        let distribution = ChiSquared::new(dof).ok().filter(|_| chi2.is_finite())?;
        let (above, below) = (distribution.sf(chi2), distribution.cdf(chi2));
        Some(Self {
            chi2,
            dof,
            p_value: above,
            verdict: if above < LACK_OF_FIT_LEVEL {
                FitVerdict::Misfit
            } else if below < LACK_OF_FIT_LEVEL {
                FitVerdict::NoiseOverstated
            } else {
                FitVerdict::Noise
            },
            readings,
        })
    }

    /// Returns the factor by which the noise must be multiplied to make chi-square equal to its degrees of freedom.
    pub fn noise_factor(&self) -> f64 {
        (self.chi2 / self.dof).sqrt()
    }
}

/// Sum of squared whitened residuals and number of readings, for each kind of reading.
#[derive(Clone, PartialEq, Debug, Default)]
pub(super) struct Tally(Vec<(ReadingKind, f64, usize)>);

/// Kind of reading.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum ReadingKind {
    Marks,
    WheelPosition,
    WheelAngles,
    Channel(usize),
}

impl Tally {
    /// Adds `count` readings of a kind, whose squared whitened residuals sum to `squares`.
    pub(super) fn add(&mut self, kind: ReadingKind, squares: f64, count: usize) {
        match self.0.iter_mut().find(|(of, _, _)| *of == kind) {
            Some((_, sum, counted)) => {
                *sum += squares;
                *counted += count;
            }
            None => self.0.push((kind, squares, count)),
        }
    }

    /// Returns the sum of squares over all kinds of readings, and the number of readings.
    pub(super) fn total(&self) -> (f64, usize) {
        let (mut sum, mut count) = (0.0, 0);
        for (_, squares, readings) in &self.0 {
            sum += squares;
            count += readings;
        }
        (sum, count)
    }

    /// Returns the residuals of each kind of reading for display.
    pub(super) fn kinds(&self, measurement: &Measurement) -> Vec<ReadingsLeft> {
        let mut kinds = self.0.clone();
        kinds.sort_by_key(|(kind, _, _)| *kind);
        let of = |(kind, squares, count): (ReadingKind, f64, usize)| ReadingsLeft {
            kind: match kind {
                ReadingKind::Marks => "marks".to_string(),
                ReadingKind::WheelPosition => "wheel position".to_string(),
                ReadingKind::WheelAngles => "wheel angles".to_string(),
                ReadingKind::Channel(channel) => measurement.channels[channel].name.clone(),
            },
            count,
            rms_over_sigma: (squares / count as f64).sqrt(),
        };
        kinds.into_iter().map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Upper 0.1 percent points from tables of chi-square: 29.588 at 10 degrees of freedom, 149.449 at 100.
    #[test]
    fn the_exact_distribution_decides() {
        for (chi2, dof) in [(29.588, 10.0), (149.449, 100.0)] {
            let verdict = |factor: f64| {
                FitTest::new(factor * chi2, dof, Vec::new())
                    .unwrap()
                    .verdict
            };
            assert_eq!(verdict(0.999), FitVerdict::Noise, "{dof}");
            assert_eq!(verdict(1.001), FitVerdict::Misfit, "{dof}");
        }
        // A chi-square of 1.29 per degree of freedom is insignificant at 10 degrees of freedom. At 1,850, it exceeds its mean by 9 standard
        // deviations.
        let p = |dof: f64| FitTest::new(1.29 * dof, dof, Vec::new()).unwrap();
        assert_eq!(p(10.0).verdict, FitVerdict::Noise);
        assert_eq!(p(1850.0).verdict, FitVerdict::Misfit);
        assert!(p(1850.0).p_value < 1e-15);
        let overstated = FitTest::new(0.25 * 1850.0, 1850.0, Vec::new()).unwrap();
        assert_eq!(overstated.verdict, FitVerdict::NoiseOverstated);
        assert!((overstated.noise_factor() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn without_degrees_of_freedom_there_is_no_test() {
        assert!(FitTest::new(1.0, 0.0, Vec::new()).is_none());
        assert!(FitTest::new(f64::NAN, 3.0, Vec::new()).is_none());
    }
}
