//! Uncertainty of a proportion estimated from a count.

/// Returns the exact 95 percent interval (Clopper and Pearson, 1934) of a proportion with `good` successes in `all` trials.
pub fn interval95(good: usize, all: usize) -> (f64, f64) {
    // Probability of at most `k` successes at a proportion `p`.
    let at_most = |k: usize, p: f64| {
        let (mut term, mut sum) = ((all as f64 * (1.0 - p).ln()).exp(), 0.0);
        for j in 0..=k {
            sum += term;
            term *= (all - j) as f64 / (j + 1) as f64 * p / (1.0 - p);
        }
        sum
    };
    let solve = |of: &dyn Fn(f64) -> f64| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let p = 0.5 * (low + high);
            if of(p) > 0.025 {
                low = p;
            } else {
                high = p;
            }
        }
        0.5 * (low + high)
    };
    let high = if good == all {
        1.0
    } else {
        solve(&|p| at_most(good, p))
    };
    let low = if good == 0 {
        0.0
    } else {
        // The other tail follows by exchanging successes and failures.
        1.0 - solve(&|q| {
            let p = 1.0 - q;
            1.0 - at_most(good - 1, p)
        })
    };
    (low, high)
}

#[test]
fn the_interval_of_a_count() {
    // Hanley and Lippman-Hand (1983): 0 of 200 gives an upper limit of 1 - 0.025^(1/200) = 1.83 percent.
    let (low, high) = interval95(0, 200);
    assert!(low == 0.0 && (high - 0.018_276).abs() < 1e-5, "{high}");
    // The interval of one half is symmetric; 5 of 10 gives 18.7 to 81.3 percent in every table.
    let (low, high) = interval95(5, 10);
    assert!(
        (low - 0.187).abs() < 1e-3 && (high - 0.813).abs() < 1e-3,
        "{low} {high}"
    );
}
