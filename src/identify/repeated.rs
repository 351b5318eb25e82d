use serde::Serialize;

/// Distribution of one number over repeated fits of simulated readings, or over draws from the posterior.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Repeated {
    /// Median.
    pub median: f64,
    /// Standard deviation of ln K times the value, in the unit of the value.
    pub std_error: f64,
    /// 2.5 and 97.5 percentiles.
    pub interval95: [f64; 2],
    /// Width of `interval95` relative to the profile-likelihood interval, both in ln K; `None` if the latter is unbounded.
    pub width_ratio: Option<f64>,
    /// Posterior only: effective number of independent draws.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_draws: Option<f64>,
    /// Posterior only: potential scale reduction factor of split chains; 1 at convergence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub r_hat: Option<f64>,
}

/// Settings and summary of a bootstrap.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct BootstrapMade {
    /// Number of fits.
    pub replicates: u64,
    /// Number of fits without a solution.
    pub without_answer: u64,
    /// Random seed.
    pub seed: u64,
    /// Rms of the whitened residuals that are resampled; 1 if noise and tolerances agree with the fit.
    pub noise_ratio: f64,
}

/// Settings and summary of a posterior sampling run.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct PosteriorMade {
    /// Number of draws over all chains.
    pub draws: u64,
    /// Number of chains.
    pub chains: u64,
    /// Random seed.
    pub seed: u64,
    /// Mean acceptance probability of a trajectory.
    pub acceptance: f64,
    /// Leapfrog steps per trajectory.
    pub steps: usize,
}
