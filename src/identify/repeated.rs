use serde::Serialize;

/// Distribution of one identified parameter over repeated fits of simulated readings, or over draws from the posterior.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Repeated {
    /// Median of the distribution, in the unit of the parameter.
    pub median: f64,
    /// Standard deviation of the logarithm of the parameter, multiplied by its value; in the unit of the parameter.
    pub std_error: f64,
    /// 2.5th and 97.5th percentiles.
    pub interval95: [f64; 2],
    /// Ratio of the width of `interval95` to the width of the profile-likelihood interval, both on the logarithmic scale. `None` if the
    /// profile-likelihood interval is unbounded.
    pub width_ratio: Option<f64>,
    /// Effective number of independent draws; only for draws from the posterior.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_draws: Option<f64>,
    /// Potential scale reduction factor of split chains, 1 at convergence; only for draws from the posterior.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub r_hat: Option<f64>,
}

/// Settings and summary of a bootstrap.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct BootstrapMade {
    /// Number of repeated fits.
    pub replicates: u64,
    /// Number of repeated fits that found no solution.
    pub without_answer: u64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Rms of the whitened residuals that the bootstrap resamples; 1 if noise and tolerances are as large as assumed.
    pub noise_ratio: f64,
}

/// Settings and summary of a posterior sampling run.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct PosteriorMade {
    /// Total number of draws over all chains.
    pub draws: u64,
    /// Number of chains.
    pub chains: u64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Mean acceptance probability of a trajectory.
    pub acceptance: f64,
    /// Number of leapfrog steps per trajectory.
    pub steps: usize,
}
