use super::number::number;
use super::{Align, Page, Table};
use admire_identify::{Fit, ParameterFit};

/// Adds a table that compares three kinds of interval of each parameter: by profile likelihood, by bootstrap (fits of resampled readings),
/// and by posterior draws.
pub(super) fn repeats(page: &mut Page, fit: &Fit, named: &dyn Fn(&ParameterFit) -> String) {
    let (bootstrap, posterior) = (fit.bootstrap, fit.posterior);
    if bootstrap.is_none() && posterior.is_none() {
        return;
    }
    page.detail("Intervals by bootstrap and sampling");
    let mut columns = vec![
        ("parameter", Align::Left),
        ("profile likelihood", Align::Right),
    ];
    if bootstrap.is_some() {
        columns.extend([("bootstrap", Align::Right), ("width ratio", Align::Right)]);
    }
    if posterior.is_some() {
        columns.extend([
            ("posterior", Align::Right),
            ("width ratio", Align::Right),
            ("effective sample size", Align::Right),
            ("R-hat", Align::Right),
        ]);
    }
    let mut table = Table::new(&columns);
    for parameter in &fit.parameters {
        let ends = |sides: [Option<f64>; 2]| {
            let show = |side: Option<f64>| {
                side.map_or_else(
                    || "no bound".to_string(),
                    |v| number(v, parameter.std_error),
                )
            };
            sides.map(show).join(" … ")
        };
        let ratio = |ratio: Option<f64>| ratio.map_or_else(String::new, |r| format!("{r:.2}"));
        let mut cells = vec![
            named(parameter),
            ends(parameter.profile95.unwrap_or_default()),
        ];
        for found in [&parameter.bootstrap, &parameter.posterior]
            .into_iter()
            .flatten()
        {
            cells.extend([ends(found.interval95.map(Some)), ratio(found.width_ratio)]);
            if let (Some(worth), Some(r_hat)) = (found.effective_draws, found.r_hat) {
                cells.extend([format!("{worth:.0}"), format!("{r_hat:.3}")]);
            }
        }
        table.row(cells);
    }
    page.table(&table);
    if let Some(made) = bootstrap {
        page.note(&format!(
            "Bootstrap: {} fits to resampled readings, seed {}. The resampled residuals are {:.2} times as large as noise and tolerances predict. Readings are resampled one by one, not as whole load cases, because the cases share their tolerances.",
            made.replicates, made.seed, made.noise_ratio
        ));
    }
    if let Some(made) = posterior {
        page.note(&format!(
            "Posterior: {} samples in {} chains by Hamiltonian Monte Carlo, seed {}, acceptance rate {:.0} %.",
            made.draws,
            made.chains,
            made.seed,
            100.0 * made.acceptance
        ));
    }
    page.note("Width ratio: width of the interval divided by that of the profile likelihood, both of the logarithm of the parameter. All three methods marginalise the tolerances.");
}
