//! Identification of a study by the method that the study names.

use std::ops::ControlFlow;
use std::sync::Arc;

use crate::fit_with_random_effects;
use admire_identify::global::gauss_newton::Tolerances;
use admire_identify::global::{Marginal, Options, Prepared, Start, fit_study};
use admire_identify::{
    Fit, IdentifyError, LoadedStudy, NumberFit, direct, estimate_noise, regression, written,
};
use admire_session::backend::Backend;
use admire_study::settings::{BackendChoice, Method};
use admire_syntax::diagnostic::{Code, Diagnostic};

use crate::watch::ProgressObserver;

/// Identifies the stiffnesses of a study. The sensor noise that the study does not state is estimated first. The fit then includes
/// tolerances if the method supports them.
///
/// # Errors
/// [`IdentifyError`] with the reason why there is no fit.
pub fn identify(
    loaded: &mut LoadedStudy,
    backend: &mut dyn Backend,
    watch: &dyn ProgressObserver,
) -> Result<Fit, IdentifyError> {
    identify_with(loaded, backend, watch, false).map(|(fit, _)| fit)
}

/// Identifies a study as [`identify`] does. If `wanted`, also returns the joint posterior of the identified parameters with all other
/// unknowns marginalised. Not every method provides this posterior.
///
/// # Errors
/// [`IdentifyError`] with the reason why there is no fit.
pub fn identify_with(
    loaded: &mut LoadedStudy,
    backend: &mut dyn Backend,
    watch: &dyn ProgressObserver,
    wanted: bool,
) -> Result<(Fit, Option<Marginal>), IdentifyError> {
    watch.stage("noise of the sensors");
    noise(loaded, backend)?;
    among_tolerances(loaded, backend, watch, wanted)
}

/// Returns a diagnostic if the study supports neither bootstrap nor posterior sampling, otherwise `None`. Both repeat the fit thousands of
/// times, which only the joint fit with the built-in solver allows.
pub fn not_repeatable(loaded: &LoadedStudy) -> Option<Diagnostic> {
    let study = &loaded.study;
    let (message, keys, help) = if study.identify.method != Method::GaussNewton {
        let message = format!(
            "bootstrap and posterior need method = \"gauss-newton\", not \"{}\"",
            study.identify.method.as_str()
        );
        (
            message,
            ["identify", "method"],
            "leave out the option, or use --method gauss-newton",
        )
    } else if study.solver.backend != BackendChoice::Native {
        let message = "bootstrap and posterior need the exact derivatives of the built-in solver";
        (
            message.to_string(),
            ["solver", "backend"],
            "leave out the option, or set backend = \"native\"",
        )
    } else {
        return None;
    };
    let place = study.place(&keys);
    let error = Diagnostic::error(Code::BadSetting, message).help(help);
    Some(error.label(study.source.name(), place, ""))
}

/// Returns the diagnostic for a study without parameters to identify. It is located at the setting `bushings`.
pub fn nothing_to_identify(loaded: &LoadedStudy) -> Diagnostic {
    let study = &loaded.study;
    let message = "the study names no parameters to identify";
    let help = if loaded.model.bushings.is_empty() {
        "the deck has no BUSHING; name numbers: stiffnesses = [\"SPRINGDAMPER/1.K\"]".to_string()
    } else {
        let names: Vec<String> = loaded
            .model
            .bushings
            .iter()
            .take(3)
            .map(|bushing| format!("\"BUSHING/{}\"", bushing.header.id))
            .collect();
        format!(
            "bushings = [{}]; without the key, every BUSHING is identified",
            names.join(", ")
        )
    };
    let error = Diagnostic::error(Code::MissingSetting, message).help(help);
    error.label(
        study.source.name(),
        study.place(&["identify", "bushings"]),
        "",
    )
}

/// Returns the diagnostic for a study without a wheel, for which wheel curves are not available.
pub fn no_wheel() -> Diagnostic {
    let message = "the study names no wheel, and its loads act at no marker";
    Diagnostic::error(Code::MissingSetting, message)
        .help("name the marker at the wheel centre in a section [wheel] or [kc]")
}

/// Estimates the sensor noise that the study does not state, with the backend that solves the study.
fn noise(loaded: &mut LoadedStudy, backend: &mut dyn Backend) -> Result<(), IdentifyError> {
    let external = loaded.study.solver.backend != BackendChoice::Native;
    estimate_noise(loaded, external.then_some(backend))
}

/// Runs the fit with tolerances if possible, otherwise the plain fit. Intervals from the fit with tolerances need no profile likelihoods.
fn among_tolerances(
    loaded: &LoadedStudy,
    backend: &mut dyn Backend,
    watch: &dyn ProgressObserver,
    wanted: bool,
) -> Result<(Fit, Option<Marginal>), IdentifyError> {
    if !allows_for_tolerances(loaded) {
        return fitted_with(loaded, backend, watch, (true, wanted));
    }
    let (mut fit, _) = fitted_with(loaded, backend, watch, (false, false))?;
    if fit.interrupted {
        return Ok((fit, None));
    }
    let problem = loaded.problem();
    watch.stage("allowing for tolerances");
    let found = fit
        .fit_test
        .as_ref()
        .and_then(|_| fit_with_random_effects(&problem));
    let Some(found) = found else {
        return fitted_with(loaded, backend, watch, (true, wanted));
    };
    let marginal = wanted.then(|| found.marginal(problem.unknowns.len()));
    found.apply(&mut fit);
    for (parameter, unknown) in fit.parameters.iter_mut().zip(&problem.unknowns) {
        parameter.numbers = NumberFit::of(unknown, parameter.value);
    }
    let decks = [problem.initial(), fit.values()].map(|values| problem.sweep(backend, &values));
    if let [Ok(before), Ok(after)] = &decks {
        written(&mut fit, &problem, before, after);
    }
    Ok((fit, marginal))
}

/// Returns true if tolerances can be fitted together with the stiffnesses. This requires Gauss-Newton with the built-in solver, and no frame
/// errors in the settings.
fn allows_for_tolerances(loaded: &LoadedStudy) -> bool {
    let settings = &loaded.study.identify;
    let frames = [0, 3].map(|axis| settings.frame_sd.of_axis(axis, &loaded.model.units));
    let frames = frames.iter().any(|sd| *sd > 0.0);
    settings.method == Method::GaussNewton
        && loaded.study.solver.backend == BackendChoice::Native
        && !frames
}

/// Runs the study's method with a backend, and reports progress. If `profile` is set and the solver is the built-in solver, poorly
/// determined parameters get intervals by profile likelihood.
///
/// # Errors
/// [`IdentifyError`] with the reason why there is no fit.
pub fn fitted(
    loaded: &LoadedStudy,
    backend: &mut dyn Backend,
    watch: &dyn ProgressObserver,
    profile: bool,
) -> Result<Fit, IdentifyError> {
    fitted_with(loaded, backend, watch, (profile, false)).map(|(fit, _)| fit)
}

fn fitted_with(
    loaded: &LoadedStudy,
    backend: &mut dyn Backend,
    watch: &dyn ProgressObserver,
    (profile, wanted): (bool, bool),
) -> Result<(Fit, Option<Marginal>), IdentifyError> {
    let problem = loaded.problem();
    let cases = loaded.programme.cases.len();
    watch.stage("identifying");
    let mut marginal = None;
    let mut fit = match loaded.study.identify.method {
        Method::Regression => {
            let most = loaded.study.regression.max_iterations;
            let mut each = |iteration: usize, _: &[f64], moves: f64| {
                watch.detail(format!("largest change {:.2} %", 100.0 * moves));
                watch.count(iteration, Some(most), "iterations");
                flow(watch)
            };
            regression::identify(&problem, backend, &mut each)?
        }
        Method::Direct => {
            let mut each = |round: usize, _: &[f64], moves: f64| {
                watch.detail(format!("round {round}, largest change of ln K {moves:.1e}"));
                flow(watch)
            };
            direct::identify(&problem, backend, &mut each)?
        }
        Method::GaussNewton => {
            let external = loaded.study.solver.backend != BackendChoice::Native;
            let prepared = Arc::new(if external {
                Prepared::external(&problem)?
            } else {
                Prepared::new(&problem)?
            });
            let most = Tolerances::default().max_iterations;
            let each = |iteration: usize, sweeps: usize, objective: f64| {
                watch.detail(if sweeps == 0 {
                    "starting from the direct solution".to_string()
                } else {
                    let solved = sweeps * cases;
                    format!("half chi-square {objective:.4e}, {solved} equilibria")
                });
                watch.count(iteration, Some(most), "steps");
                watch.goes_on()
            };
            let options = Options {
                start: Start::Auto,
                // Profile likelihood with an external program would take hundreds of runs.
                profile: profile && !external,
                watch: Some(Box::new(each)),
            };
            let other: Option<&mut dyn Backend> = if external { Some(backend) } else { None };
            let found = fit_study(&problem, &prepared, other, options)?;
            if wanted && !external {
                let sought = problem.unknowns.len();
                marginal = Some(Marginal::of(&found, Arc::clone(&prepared), sought));
            }
            found.fit
        }
    };
    fit.inputs_sha256 = loaded.study.inputs_sha256();
    Ok((fit, marginal))
}

/// Ends the iteration if the observer has requested a stop.
fn flow(watch: &dyn ProgressObserver) -> ControlFlow<()> {
    if watch.goes_on() {
        ControlFlow::Continue(())
    } else {
        ControlFlow::Break(())
    }
}
