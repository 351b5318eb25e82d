//! Conversion of a direct solution to the result that `identification.json` shows.

use std::collections::BTreeMap;
use std::f64::consts::LN_10;

use super::{DirectSettings, DirectSolution, solve};
use crate::evaluation::fill;
use crate::global::confidence::open_directions;
use crate::settings::{NORMAL_QUANTILE_975, UNIDENTIFIABLE_LN_SD};
use crate::{
    Fit, IdentifyError, OffsetFit, ParameterFit, Problem, Progress, Status, UnidentifiableDirection,
};
use admire_session::backend::Backend;
use admire_study::settings::Method;

/// Identifies the parameters by the direct solution. The backend is used only to evaluate the result, in one sweep with the initial and one
/// with the identified values.
///
/// # Errors
/// Returns [`IdentifyError`] if there is no direct solution, or if a sweep of the backend fails as a whole.
pub fn identify(
    problem: &Problem<'_>,
    backend: &mut dyn Backend,
    progress: &mut Progress<'_>,
) -> Result<Fit, IdentifyError> {
    let mut interrupted = false;
    let mut watch = |round: usize, values: &[f64], moves: f64| {
        let goes_on = progress(round, values, moves);
        interrupted |= goes_on.is_break();
        goes_on
    };
    let solution = solve(problem, &DirectSettings::default(), &mut watch)?;
    let interrupted = interrupted && !solution.settled;
    let before = problem.sweep(backend, &problem.initial())?;
    let after = problem.sweep(backend, &solution.values)?;
    let mut fit = Fit {
        method: Method::Direct.as_str().to_string(),
        backend: backend.name().to_string(),
        converged: solution.settled,
        iterations: solution.rounds,
        solver_runs: 2 * problem.programme.cases.len(),
        balance: backend.balance().cloned(),
        parameters: parameters(problem, &solution),
        assembly_offsets: offsets(problem, &solution),
        unidentifiable_directions: directions(problem, &solution),
        history: vec![problem.initial(), solution.values.clone()],
        remarks: remarks(problem, &solution),
        ..Fit::default()
    };
    fill(&mut fit, problem, &before, &after, problem.unknowns.len());
    if interrupted {
        fit.cut_short();
    }
    Ok(fit)
}

fn sd_log(solution: &DirectSolution, k: usize) -> f64 {
    solution.covariance[(k, k)].max(0.0).sqrt()
}

fn parameters(problem: &Problem<'_>, solution: &DirectSolution) -> Vec<ParameterFit> {
    let count = problem.unknowns.len();
    let correlation = |k: usize| {
        let others = (0..count).filter(|other| *other != k);
        let with = others.map(|other| {
            let scale = sd_log(solution, k) * sd_log(solution, other);
            if scale > 0.0 {
                (solution.covariance[(k, other)] / scale).abs()
            } else {
                0.0
            }
        });
        with.fold(0.0, f64::max)
    };
    let one = |(k, unknown): (usize, &crate::Unknown)| {
        let (value, sd) = (solution.values[k], sd_log(solution, k));
        let reach = NORMAL_QUANTILE_975 * sd;
        // An interval end more than three decades from the value is omitted.
        let side = |factor: f64| (reach < 3.0 * LN_10).then_some(value * factor);
        ParameterFit {
            address: unknown.address.to_string(),
            tied: unknown.tied().iter().map(ToString::to_string).collect(),
            numbers: Vec::new(),
            form: None,
            unit: unknown.unit.clone(),
            initial: unknown.initial,
            value,
            std_error: Some(value * sd),
            interval95: [side(libm::exp(-reach)), side(libm::exp(reach))],
            correlation: Some(correlation(k)),
            tolerance_share: None,
            profile95: None,
            bootstrap: None,
            posterior: None,
            status: if solution.at_bound[k] {
                Status::Bound
            } else if sd > UNIDENTIFIABLE_LN_SD {
                Status::Unidentifiable
            } else {
                Status::Identified
            },
        }
    };
    problem.unknowns.iter().enumerate().map(one).collect()
}

fn offsets(problem: &Problem<'_>, solution: &DirectSolution) -> Vec<OffsetFit> {
    let mut fits: Vec<OffsetFit> = Vec::new();
    let count = problem.unknowns.len();
    for (o, (bushing, axis, delta)) in solution.offsets.iter().enumerate() {
        let address = format!("BUSHING/{}", problem.model.bushings[*bushing].header.id);
        if fits.last().is_none_or(|last| last.address != address) {
            fits.push(OffsetFit {
                address,
                delta: [0.0; 6],
                std_error: [None; 6],
            });
        }
        let fit = fits.last_mut().expect("pushed just above");
        fit.delta[*axis] = *delta;
        fit.std_error[*axis] = Some(sd_log(solution, count + o));
    }
    fits
}

fn directions(problem: &Problem<'_>, solution: &DirectSolution) -> Vec<UnidentifiableDirection> {
    let open = open_directions(
        &solution.covariance,
        problem.unknowns.len(),
        UNIDENTIFIABLE_LN_SD,
    );
    open.into_iter()
        .map(|direction| {
            let shares = direction
                .weights
                .iter()
                .map(|(k, weight)| (problem.unknowns[*k].address.to_string(), *weight));
            UnidentifiableDirection {
                combination: shares.collect::<BTreeMap<_, _>>(),
                sd_log: direction.sd,
            }
        })
        .collect()
}

/// Returns remarks on the bias of plain least squares, on load cases that were left out, and on missing convergence.
fn remarks(problem: &Problem<'_>, solution: &DirectSolution) -> Vec<String> {
    let mut remarks = Vec::new();
    let mut worst: Option<(usize, f64)> = None;
    for (k, plain) in solution.uncorrected.iter().enumerate() {
        let bias = libm::log(plain / solution.values[k]);
        if sd_log(solution, k) <= UNIDENTIFIABLE_LN_SD
            && worst.is_none_or(|(_, b)| bias.abs() > b.abs())
        {
            worst = Some((k, bias));
        }
    }
    if let Some((k, bias)) = worst
        && bias.abs() > 0.02
    {
        remarks.push(format!(
            "Noise in the measured poses would bias plain weighted least squares. The correction changes {} most: without it, the value is {:.2} \
             times the value given here. The remaining bias is of second order in the noise.",
            problem.unknowns[k].address,
            libm::exp(bias)
        ));
    }
    let fitted: Vec<usize> = problem.measurement.fitted_cases().collect();
    let left_out = fitted.iter().filter(|case| !solution.cases.contains(case));
    let labels: Vec<&str> = left_out
        .map(|case| problem.measurement.cases[*case].label.as_str())
        .collect();
    if !labels.is_empty() {
        remarks.push(format!(
            "Load cases without the pose of every moving part are not used: {}.",
            labels.join(", ")
        ));
    }
    if !solution.settled {
        remarks.push("The correction for pose noise did not converge.".to_string());
    }
    remarks
}
