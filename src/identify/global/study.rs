//! Fit of a study with any solver, from the most suitable starting values.

use std::ops::ControlFlow;

use super::differences::DifferencePredictor;
use super::fit::{Found, GlobalFit, global_problem, identify};
use super::gauss_newton::Ending;
use super::observation::Observations;
use super::prepared::Prepared;
use super::problem::{GlobalProblem, Watch};
use super::start_values::{StartValues, fit_unknowns};
use crate::direct::{self, DirectSettings, DirectSolution};
use crate::settings::{CONTRADICTION_SD, POOR_NORMAL_LN_SD};
use crate::{Fit, IdentifyError, Problem};
use admire_session::backend::Backend;

/// Choice of the starting values of a fit.
#[derive(Clone, PartialEq, Debug, Default)]
pub enum Start {
    /// The direct solution if it saves time, otherwise the initial values of the study.
    ///
    /// With an external solver, sweeps are expensive, and the direct solution saves most of them. With the built-in solver, a fit from the
    /// initial values takes a tenth of the time of the direct solution. The direct solution is then used only if that fit fails.
    #[default]
    Auto,
    /// The direct solution if it converged, otherwise the initial values of the study.
    Direct,
    /// The initial values of the study.
    Initial,
    /// Explicitly given values.
    At(StartValues),
}

/// Options of a fit.
#[derive(Default)]
pub struct Options<'a> {
    /// Choice of the starting values.
    pub start: Start,
    /// True if wide intervals are to be refined by profile likelihood, which costs solver runs.
    pub profile: bool,
    /// Callback that may stop the fit.
    pub watch: Option<Box<Watch<'a>>>,
}

/// Combines a fit with its least-squares problem, and adds remarks where the fit contradicts the direct solution.
fn together<'a>(
    mut found: Found,
    problem: &Problem<'_>,
    mut global: GlobalProblem<'a>,
    direct: Option<&DirectSolution>,
) -> GlobalFit<'a> {
    global.watch = None;
    if let Some(solution) = direct {
        sanity(problem, &mut found.fit, solution);
    }
    GlobalFit {
        fit: found.fit,
        problem: global,
        minimum: found.minimum,
        covariance: found.covariance,
    }
}

/// Fits a study with the built-in solver, or with another backend by finite differences.
///
/// # Errors
/// See [`identify`] and [`Prepared::new`].
pub fn fit_study<'a>(
    problem: &'a Problem<'a>,
    prepared: &'a Prepared,
    backend: Option<&'a mut dyn Backend>,
    options: Options<'a>,
) -> Result<GlobalFit<'a>, IdentifyError> {
    let Options {
        start,
        profile,
        mut watch,
    } = options;
    let direct = match &start {
        Start::Direct => direct_start(problem, watch.as_deref_mut()),
        Start::Auto if backend.is_some() => direct_start(problem, watch.as_deref_mut()),
        Start::Auto | Start::Initial | Start::At(_) => None,
    };
    let cases: Vec<usize> = problem.measurement.fitted_cases().collect();
    let observations = Observations::fitted(problem.measurement, problem.model, &cases);
    let begin = match &start {
        Start::At(values) => Some(values.clone()),
        _ => direct.as_ref().map(start_at),
    };
    let unknowns = fit_unknowns(problem, &prepared.system, begin.as_ref());
    let observed = observations.observed.clone();
    let Some(backend) = backend else {
        let predictor = Box::new(prepared.native(problem, observed)?);
        let mut global = global_problem(problem, observations, unknowns, predictor);
        global.watch = watch;
        let outcome = identify(problem, &mut global, "native", profile);
        let lost = match &outcome {
            Ok(found) => !found.fit.converged && found.minimum.ending != Ending::Stopped,
            Err(_) => true,
        };
        if start != Start::Auto || !lost {
            return outcome.map(|found| together(found, problem, global, direct.as_ref()));
        }
        let Some(solution) = direct_start(problem, global.watch.as_deref_mut()) else {
            return outcome.map(|found| together(found, problem, global, None));
        };
        let begin = start_at(&solution);
        global.unknowns = fit_unknowns(problem, &prepared.system, Some(&begin));
        let again = identify(problem, &mut global, "native", profile);
        let better = match (outcome, again) {
            (Ok(first), Ok(second)) if first.minimum.objective < second.minimum.objective => {
                Ok(first)
            }
            (Ok(first), Err(_)) => Ok(first),
            (_, second) => second,
        };
        return better.map(|found| together(found, problem, global, Some(&solution)));
    };
    let name = backend.name();
    let predictor = DifferencePredictor::new(problem, prepared, backend, observed);
    let failure = predictor.failure();
    let mut global = global_problem(problem, observations, unknowns, Box::new(predictor));
    global.watch = watch;
    let outcome = identify(problem, &mut global, name, profile);
    match (outcome, failure.take()) {
        (Err(IdentifyError::NoCases(None)), Some(error)) => Err(error.into()),
        (_, Some(error)) if error.is_lasting() => Err(error.into()),
        (outcome, _) => outcome.map(|found| together(found, problem, global, direct.as_ref())),
    }
}

/// Converts a direct solution to starting values of a fit.
fn start_at(solution: &DirectSolution) -> StartValues {
    StartValues {
        values: solution.values.clone(),
        offsets: solution.offsets.clone(),
    }
}

/// Computes the direct solution of the problem. Returns `None` if it fails or does not converge.
fn direct_start(problem: &Problem<'_>, watch: Option<&mut Watch<'_>>) -> Option<DirectSolution> {
    let settings = DirectSettings {
        show_bias: false,
        ..DirectSettings::default()
    };
    let mut watch = watch;
    let mut progress = |_: usize, _: &[f64], _: f64| {
        let goes_on = watch
            .as_mut()
            .is_none_or(|watch| watch(0, 0, f64::INFINITY));
        if goes_on {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    };
    let solution = direct::solve(problem, &settings, &mut progress).ok()?;
    solution.settled.then_some(solution)
}

/// Adds a remark for each parameter whose direct solution differs from the fit by more than chance. The direct solution needs no solver run, so
/// it is an independent check of the model.
fn sanity(problem: &Problem<'_>, fit: &mut Fit, solution: &DirectSolution) {
    for (k, parameter) in fit.parameters.iter().enumerate() {
        let sd = solution.covariance[(k, k)].max(0.0).sqrt();
        let apart = libm::log(solution.values[k] / parameter.value);
        if sd < POOR_NORMAL_LN_SD && apart.abs() > CONTRADICTION_SD * sd.max(1e-3) {
            fit.remarks.push(format!(
                "The direct solution of the measured poses puts {} at {:.2} times the value given here, {:.0} standard \
                 deviations away. This points to an element that the model lacks or has wrong.",
                problem.unknowns[k].address,
                libm::exp(apart),
                apart.abs() / sd
            ));
        }
    }
}
