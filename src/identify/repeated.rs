use serde::Serialize;

/// What fits of readings drawn anew, or draws from the posterior, say of one number.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Repeated {
    /// Median.
    pub median: f64,
    /// Standard deviation of ln K times the value, in the unit of the value.
    pub std_error: f64,
    /// 2.5 and 97.5 percent of all.
    pub interval95: [f64; 2],
    /// Its width over that of the interval by profile likelihood, both of ln K; `None` where that has no bound.
    pub width_ratio: Option<f64>,
    /// Posterior: how many independent draws the draws are worth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_draws: Option<f64>,
    /// Posterior: potential scale reduction of split chains; one where they agree.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub r_hat: Option<f64>,
}

/// How a bootstrap was made.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct BootstrapMade {
    /// Fits.
    pub replicates: u64,
    /// Those of them without an answer.
    pub without_answer: u64,
    /// Seed.
    pub seed: u64,
    /// Root of the mean square of the residuals that are drawn, whitened: one if noise and tolerances are as the fit has them.
    pub noise_ratio: f64,
}

/// How draws from the posterior were made.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct PosteriorMade {
    /// Draws of all chains.
    pub draws: u64,
    /// Chains.
    pub chains: u64,
    /// Seed.
    pub seed: u64,
    /// Mean probability with which the end of a trajectory was accepted.
    pub acceptance: f64,
    /// Leapfrog steps of a trajectory.
    pub steps: usize,
}
