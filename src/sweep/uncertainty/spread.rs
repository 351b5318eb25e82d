use super::chains::{effective_draws, split_r_hat};
use admire_identify::{Repeated, Unknown};

/// Summarises the repeated values of an unknown, which are given chain by chain. Quantiles and widths are computed for the coordinate of
/// the unknown. `estimate` is its estimate, and `profile` is its profile-likelihood interval.
pub(crate) fn spread(
    chains: &[Vec<f64>],
    unknown: &Unknown,
    (estimate, profile): (f64, [Option<f64>; 2]),
    chained: bool,
) -> Repeated {
    let coordinates: Vec<Vec<f64>> = chains
        .iter()
        .map(|chain| {
            let values = chain.iter();
            values.map(|value| unknown.coordinate(*value)).collect()
        })
        .collect();
    let mut all: Vec<f64> = coordinates.iter().flatten().copied().collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let squares: f64 = all.iter().map(|x| (x - mean) * (x - mean)).sum();
    let sd = (squares / (all.len() as f64 - 1.0)).sqrt();
    all.sort_by(f64::total_cmp);
    let [low, median, high] = [0.025, 0.5, 0.975].map(|p| quantile(&all, p));
    let width_ratio = match profile.map(|side| side.map(|value| unknown.coordinate(value))) {
        [Some(from), Some(to)] => Some((high - low) / (to - from)).filter(|r| r.is_finite()),
        _ => None,
    };
    Repeated {
        median: unknown.value(median),
        std_error: unknown.value_rate(unknown.coordinate(estimate)) * sd,
        interval95: [low, high].map(|x| unknown.value(x)),
        width_ratio,
        effective_draws: chained.then(|| effective_draws(&coordinates)),
        r_hat: chained.then(|| split_r_hat(&coordinates)),
    }
}

/// Returns a quantile by linear interpolation between sorted values (Hyndman and Fan 1996, type 8). The median of an odd number of values
/// is the middle value.
fn quantile(sorted: &[f64], p: f64) -> f64 {
    let n = sorted.len() as f64;
    let at = (p * (n + 1.0 / 3.0) + 1.0 / 3.0 - 1.0).clamp(0.0, n - 1.0);
    let (below, share) = (at.floor() as usize, at.fract());
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + share * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Stream, normal};
    use admire_identify::{Assignment, Place};
    use admire_syntax::Address;

    #[test]
    fn a_lognormal_number_has_its_own_interval() {
        let stream = Stream::named(3, "values");
        let draw = |k: u64| (0.1 * normal::quantile(stream.uniform(k))).exp() * 1000.0;
        let values: Vec<f64> = (0..40_000).map(draw).collect();
        let z = 1.959_964 * 0.1_f64;
        let profile = [Some(1000.0 * (-z).exp()), Some(1000.0 * z.exp())];
        let unknown = Unknown {
            address: Address {
                kind: "SPRINGDAMPER".to_string(),
                id: Some(1),
                argument: Some("K".to_string()),
                index: None,
            },
            assignment: Assignment::Equal(Vec::new()),
            place: Place::Number,
            unit: String::new(),
            initial: 1000.0,
            deck: 1000.0,
            mean: None,
            sd: None,
            bounds: None,
        };
        let found = spread(&[values], &unknown, (1000.0, profile), false);
        assert!((found.std_error / 100.0 - 1.0).abs() < 0.02, "{found:?}");
        assert!((found.median / 1000.0 - 1.0).abs() < 0.003);
        assert!((found.interval95[0] / (1000.0 * (-z).exp()) - 1.0).abs() < 0.005);
        assert!((found.width_ratio.unwrap() - 1.0).abs() < 0.02);
    }
}
