//! Bootstrap: repeated fits to resampled readings.

use nalgebra::DVector;

use super::estimate::Estimate;
use crate::{Row, Status, Stream, normal};
use admire_identify::global::Row as Reading;
use admire_identify::global::gauss_newton::{Ending, Prior, Tolerances};

/// Smallest number of residuals for which a kind of reading has its own pool; rarer kinds share one pool.
const FEW: usize = 20;
/// Upper limit of the leverage. A reading of higher leverage nearly determines its own prediction, so its residual carries no information.
const LEVERAGE: f64 = 0.99;

/// Data from which every bootstrap replicate is drawn.
pub(crate) struct Bootstrap<'a> {
    estimate: &'a Estimate<'a>,
    stream: Stream,
    /// Pools of errors, one for each kind of reading and one shared pool.
    pools: Vec<Vec<f64>>,
    /// Index of the pool of each residual.
    pool_of: Vec<usize>,
    /// Root mean square of all pooled errors. It is 1 if noise and tolerances are as large as the fit assumes.
    pub noise_ratio: f64,
}

impl<'a> Bootstrap<'a> {
    /// Prepares the bootstrap of a fit; `seed` is the seed of all draws.
    pub(crate) fn new(estimate: &'a Estimate<'a>, seed: u64) -> Self {
        let kinds = kinds(estimate);
        let (pools, pool_of) = pools(
            &kinds,
            &estimate.minimum.evaluation.residual,
            &estimate.leverages(),
        );
        let squares: Vec<f64> = pools.iter().map(|pool| mean_square(pool)).collect();
        let sum: f64 = pool_of.iter().map(|pool| squares[*pool]).sum();
        let noise_ratio = (sum / pool_of.len().max(1) as f64).sqrt();
        Self {
            estimate,
            stream: Stream::named(seed, "bootstrap"),
            pools,
            pool_of,
            noise_ratio,
        }
    }

    /// Runs one replicate. The outputs are the identified parameters and half the chi-square of the replicate.
    pub(crate) fn run(&self, case: u64) -> Row {
        let start = std::time::Instant::now();
        let fitted = self.fitted(case);
        Row::ended(case, start, fitted.map_err(|why| (Status::NoAnswer, why)))
    }

    fn fitted(&self, case: u64) -> Result<Vec<f64>, String> {
        let minimum = &self.estimate.minimum;
        let own = self.estimate.marginal.priors();
        // Each replicate has its own section of the stream.
        let first = case * (self.pool_of.len() + own.len()) as u64;
        let residual = &minimum.evaluation.residual;
        let shift = DVector::from_fn(residual.len(), |k, _| {
            let pool = &self.pools[self.pool_of[k]];
            let drawn = self.stream.below(first + k as u64, pool.len() as u64);
            residual[k] + pool[drawn as usize]
        });
        let next = first + residual.len() as u64;
        let priors: Vec<Prior> = own
            .iter()
            .enumerate()
            .map(|(k, prior)| {
                let z = normal::quantile(self.stream.uniform(next + k as u64));
                let error = if prior.sd.is_finite() {
                    prior.sd * z
                } else {
                    0.0
                };
                Prior {
                    mean: minimum.x[k] + error,
                    sd: prior.sd,
                }
            })
            .collect();
        let mut fit = self.estimate.again().map_err(|error| error.to_string())?;
        fit.shift(shift);
        let found = fit
            .minimise(&minimum.x, &priors, Tolerances::default())
            .ok_or("the model has no equilibrium at the identified numbers")?;
        if found.ending != Ending::Converged {
            return Err("the fit did not converge".to_string());
        }
        let mut outputs = self.estimate.values(&found.x);
        outputs.push(found.objective);
        Ok(outputs)
    }
}

/// Returns the kind of reading that each residual belongs to, as a number.
fn kinds(estimate: &Estimate<'_>) -> Vec<usize> {
    let problem = estimate.problem;
    let observations = estimate
        .marginal
        .observations(problem.measurement, problem.model);
    let rows = observations.rows;
    let kind = |row: usize| match rows[row] {
        Reading::Mark { .. } => 0,
        Reading::Wheel {
            component: 0..=2, ..
        } => 1,
        Reading::Wheel { .. } => 2,
        Reading::Channel { channel, .. } => 3 + channel,
    };
    estimate.marginal.rows().map(kind).collect()
}

/// Returns the pools of errors, and the index of the pool for each residual. An error is the reading minus its prediction.
fn pools(
    kinds: &[usize],
    residual: &DVector<f64>,
    leverages: &DVector<f64>,
) -> (Vec<Vec<f64>>, Vec<usize>) {
    let count = |kind: usize| kinds.iter().filter(|k| **k == kind).count();
    let last = kinds.iter().max().map_or(0, |kind| kind + 1);
    let pool_of: Vec<usize> = kinds
        .iter()
        .map(|kind| if count(*kind) < FEW { last } else { *kind })
        .collect();
    let mut pools = vec![Vec::new(); last + 1];
    for (k, pool) in pool_of.iter().enumerate() {
        let error = -residual[k] / (1.0 - leverages[k].min(LEVERAGE)).sqrt();
        pools[*pool].push(error);
    }
    if pools[last].len() < FEW {
        // If the shared pool is still too small, it contains the errors of all pools.
        let all: Vec<f64> = pools.iter().flatten().copied().collect();
        pools[last] = all;
    }
    for pool in &mut pools {
        let mean = pool.iter().sum::<f64>() / pool.len().max(1) as f64;
        for error in pool {
            *error -= mean;
        }
    }
    (pools, pool_of)
}

fn mean_square(pool: &[f64]) -> f64 {
    pool.iter().map(|e| e * e).sum::<f64>() / pool.len().max(1) as f64
}
