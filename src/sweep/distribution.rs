use super::normal;

/// Distribution of a varied parameter, in the parameter's own unit.
#[derive(Clone, PartialEq, Debug)]
pub enum Distribution {
    /// Uniform between the first and the second value.
    Uniform([f64; 2]),
    /// Normal distribution.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation, above zero.
        sd: f64,
    },
    /// Lognormal distribution.
    LogNormal {
        /// Median, above zero.
        median: f64,
        /// Standard deviation of the natural logarithm, above zero.
        sigma: f64,
    },
    /// Discrete distribution: one of several values.
    Discrete {
        /// The values.
        values: Vec<f64>,
        /// Cumulative probability up to and including each value; the last is 1.
        cumulative: Vec<f64>,
    },
    /// Value given for each case in a table.
    Given,
}

impl Distribution {
    /// Returns the quantile at probability `u`, 0 < u < 1. NaN if a table gives the values.
    pub(crate) fn quantile(&self, u: f64) -> f64 {
        match self {
            Self::Uniform([low, high]) => low + (high - low) * u,
            Self::Normal { mean, sd } => mean + sd * normal::quantile(u),
            Self::LogNormal { median, sigma } => median * libm::exp(sigma * normal::quantile(u)),
            Self::Discrete { values, cumulative } => {
                let at = cumulative.partition_point(|share| *share <= u);
                values[at.min(values.len() - 1)]
            }
            Self::Given => f64::NAN,
        }
    }

    /// Returns level `k` (from 0) of the `count` levels in a factorial plan. The levels are the values of a discrete distribution, equal
    /// steps over the range of a uniform distribution, or the midpoints of `count` intervals of equal probability.
    pub(crate) fn level(&self, k: u64, count: u64) -> f64 {
        match self {
            Self::Discrete { values, .. } => values[k as usize],
            Self::Uniform([low, high]) if count > 1 => {
                low + (high - low) * (k as f64 / (count - 1) as f64)
            }
            _ => self.quantile((k as f64 + 0.5) / count as f64),
        }
    }

    /// Returns the number of discrete values; `None` for continuous distributions.
    pub(crate) fn count(&self) -> Option<u64> {
        match self {
            Self::Discrete { values, .. } => Some(values.len() as u64),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_discrete_values_are_their_weights() {
        let d = Distribution::Discrete {
            values: vec![3.0, 5.0, 9.0],
            cumulative: vec![0.25, 0.5, 1.0],
        };
        let all: Vec<f64> = (0..8)
            .map(|k| d.quantile((f64::from(k) + 0.5) / 8.0))
            .collect();
        assert_eq!(all, [3.0, 3.0, 5.0, 5.0, 9.0, 9.0, 9.0, 9.0]);
    }

    #[test]
    fn quantiles_of_the_log_normal_are_those_of_the_normal() {
        let d = Distribution::LogNormal {
            median: 100.0,
            sigma: 0.2,
        };
        assert!((d.quantile(0.5) - 100.0).abs() < 1e-12);
        let upper = d.quantile(0.841_344_746_068_542_9);
        assert!((upper / (100.0 * 0.2_f64.exp()) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn levels_of_a_uniform_number_reach_its_ends() {
        let d = Distribution::Uniform([2.0, 6.0]);
        assert_eq!([0, 1, 2].map(|k| d.level(k, 3)), [2.0, 4.0, 6.0]);
    }
}
