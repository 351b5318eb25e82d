//! Convergence and effective number of draws of Markov chains (Gelman et al., Bayesian Data Analysis, 3rd ed., 11.4 and 11.5).

/// Splits each chain into two halves of equal length.
fn halves(chains: &[Vec<f64>]) -> Vec<&[f64]> {
    chains
        .iter()
        .flat_map(|chain| {
            let half = chain.len() / 2;
            [&chain[..half], &chain[chain.len() - half..]]
        })
        .collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn variance(values: &[f64]) -> f64 {
    let mean = mean(values);
    let sum: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    sum / (values.len() as f64 - 1.0)
}

/// Returns the mean variance within the halves, and the estimated variance of the distribution that the chains sample.
fn variances(halves: &[&[f64]]) -> (f64, f64) {
    let n = halves[0].len() as f64;
    let within = halves.iter().map(|half| variance(half)).sum::<f64>() / halves.len() as f64;
    let means: Vec<f64> = halves.iter().map(|half| mean(half)).collect();
    (within, within * (n - 1.0) / n + variance(&means))
}

/// Returns the potential scale reduction (R-hat) of split chains, which is 1 if all halves agree. NaN for chains of fewer than four draws.
pub(crate) fn split_r_hat(chains: &[Vec<f64>]) -> f64 {
    let halves = halves(chains);
    if halves.first().is_none_or(|half| half.len() < 2) {
        return f64::NAN;
    }
    let (within, whole) = variances(&halves);
    (whole / within).sqrt()
}

/// Returns the effective number of independent draws, from Geyer's initial monotone sequence of autocorrelation pairs.
pub(crate) fn effective_draws(chains: &[Vec<f64>]) -> f64 {
    let halves = halves(chains);
    if halves.first().is_none_or(|half| half.len() < 2) {
        return f64::NAN;
    }
    let n = halves[0].len();
    let (_, whole) = variances(&halves);
    // The variogram at a lag gives the autocorrelation at that lag.
    let correlation = |lag: usize| {
        let of = |half: &&[f64]| {
            let pairs = half[lag..].iter().zip(*half);
            pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>()
        };
        let sum: f64 = halves.iter().map(of).sum();
        1.0 - sum / ((halves.len() * (n - lag)) as f64) / (2.0 * whole)
    };
    let (mut sum, mut least) = (0.0, f64::INFINITY);
    let mut lag = 0;
    while lag + 1 < n {
        let pair = correlation(lag) + correlation(lag + 1);
        if pair <= 0.0 || !pair.is_finite() {
            break;
        }
        least = least.min(pair);
        sum += least;
        lag += 2;
    }
    let total = (halves.len() * n) as f64;
    total / (2.0 * sum - 1.0).max(1.0 / libm::log10(total))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Stream, normal};

    /// Creates autoregressive chains with coefficient `a`. Their effective number of draws is known: n (1 - a) / (1 + a).
    fn chains(a: f64, length: usize) -> Vec<Vec<f64>> {
        (0..8)
            .map(|chain| {
                let stream = Stream::named(chain, "autoregression");
                let mut x = normal::quantile(stream.uniform(0));
                let next = |k: usize| {
                    let e = normal::quantile(stream.uniform(1 + k as u64));
                    x = a * x + (1.0 - a * a).sqrt() * e;
                    x
                };
                (0..length).map(next).collect()
            })
            .collect()
    }

    #[test]
    fn an_autoregression_is_worth_what_its_correlation_says() {
        for a in [-0.3, 0.0, 0.5, 0.8] {
            let chains = chains(a, 4000);
            let expected = 32_000.0 * (1.0 - a) / (1.0 + a);
            let found = effective_draws(&chains);
            assert!(
                (found / expected - 1.0).abs() < 0.1,
                "{a}: {found} {expected}"
            );
            assert!((split_r_hat(&chains) - 1.0).abs() < 0.01);
        }
    }

    #[test]
    fn a_chain_that_stays_elsewhere_shows() {
        let mut all = chains(0.0, 400);
        for x in &mut all[3] {
            *x += 3.0;
        }
        assert!(split_r_hat(&all) > 1.2);
        assert!(effective_draws(&all) < 60.0);
    }
}
