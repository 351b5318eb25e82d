//! `method = "gauss-newton"`: set-up of the fit of a study, the fit itself, and its result.

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::confidence::{covariance, open_directions};
use super::gauss_newton::{Ending, Minimum, Tolerances, homotopy_start, minimise};
use super::held_curves::held_curves;
use super::observation::{NuisanceLayout, Observations, Row};
use super::predictor::{CasePrediction, Predictor};
use super::problem::GlobalProblem;
use super::profile::profile_interval;
use super::unknown::{FitUnknowns, UnknownTarget};
use crate::evaluation::fill;
use crate::goodness::{FitTest, ReadingKind, Tally};
use crate::lack_of_fit::{Residuals, lack_of_fit_tests};
use crate::settings::{
    FAR_FIT_RMS_SIGMA, NORMAL_QUANTILE_975, OUTLIER_FALSE_ALARM, POOR_NORMAL_LN_SD,
    UNIDENTIFIABLE_LN_SD,
};
use crate::unknowns::share_a_spline;
use crate::{
    Fit, IdentifyError, Marks, NOT_CONVERGED, NumberFit, OffsetFit, ParameterFit, Problem, Status,
    UnidentifiableDirection,
};
use admire_session::backend::{CaseFailure, Sweep};
use admire_solver::system::Equilibrium;
use admire_study::settings::{Loss, Method};

/// Result of a fit, together with its least-squares problem.
pub struct GlobalFit<'a> {
    /// Result of the fit, as `identification.json` shows it.
    pub fit: Fit,
    /// Least-squares problem of the fit, ready for further evaluations.
    pub problem: GlobalProblem<'a>,
    /// Final state of the minimisation.
    pub minimum: Minimum,
    /// Posterior covariance of all unknowns.
    pub covariance: DMatrix<f64>,
}

/// Result of a fit, without its least-squares problem.
pub struct Found {
    /// Result of the fit, as `identification.json` shows it.
    pub fit: Fit,
    /// Final state of the minimisation.
    pub minimum: Minimum,
    /// Posterior covariance of all unknowns.
    pub covariance: DMatrix<f64>,
}

/// Assembles the least-squares problem of a study from its readings, unknowns and predictor.
pub fn global_problem<'a>(
    problem: &Problem<'a>,
    observations: Observations<'a>,
    unknowns: FitUnknowns,
    predictor: Box<dyn Predictor + 'a>,
) -> GlobalProblem<'a> {
    let frame = problem.settings.frame_sd;
    let [frame_shift_sd, frame_turn_sd] =
        [0, 3].map(|axis| frame.of_axis(axis, &problem.model.units));
    GlobalProblem {
        deck: predictor.system().parameters(),
        layout: NuisanceLayout::new(
            problem.measurement,
            unknowns.len(),
            frame_shift_sd,
            frame_turn_sd,
        ),
        unknowns,
        observations,
        predictor,
        loss: problem.settings.loss,
        history: Vec::new(),
        watch: None,
    }
}

/// Fits all readings of the cases that are not held out. If `profile` is true, wide intervals are refined by profile likelihood, which costs
/// solver runs.
///
/// The fit starts from the starting values in `global`. If it does not converge, it is repeated from the initial values of the study. Cases
/// without an equilibrium at the start are left out and named in a remark. If they have an equilibrium at the identified parameters, the fit is
/// repeated with them.
///
/// # Errors
/// Returns [`IdentifyError::NoUnknowns`] if there are no unknowns. Returns [`IdentifyError::NoCases`] if there are no readings, or if no case
/// can be solved at the start.
pub fn identify<'a>(
    problem: &Problem<'a>,
    global: &mut GlobalProblem<'a>,
    backend: &str,
    profile: bool,
) -> Result<Found, IdentifyError> {
    if problem.unknowns.is_empty() {
        return Err(IdentifyError::NoUnknowns);
    }
    if global.observations.rows.is_empty() {
        return Err(IdentifyError::NoCases(None));
    }
    let (priors, held) = (global.priors(), global.held());
    let initial: Vec<f64> = priors.iter().map(|prior| prior.mean).collect();
    let starts = [global.start(), initial.clone()];
    let mut left_out = Vec::new();
    let mut best = attempt(global, &starts);
    if best.is_none() {
        let all: Vec<usize> = problem.measurement.fitted_cases().collect();
        left_out = unreached(global, &initial, &all);
        let kept = |left_out: &[usize]| -> Vec<usize> {
            let all = all.iter().copied();
            all.filter(|case| !left_out.contains(case)).collect()
        };
        if !left_out.is_empty() && left_out.len() < all.len() {
            let see =
                |cases: &[usize]| Observations::fitted(problem.measurement, problem.model, cases);
            global.observations = see(&kept(&left_out));
            best = attempt(global, &starts);
            // At the identified parameters, more cases may have an equilibrium.
            if let Some(found) = best.take() {
                let still = unreached(global, &found.x, &left_out);
                let more = still.len() < left_out.len();
                if more {
                    global.observations = see(&kept(&still));
                    best = attempt(global, std::slice::from_ref(&found.x));
                }
                if best.is_some() {
                    left_out = still;
                } else {
                    global.observations = see(&kept(&left_out));
                    best = Some(found);
                }
            }
        }
    }
    let minimum = best.ok_or(IdentifyError::NoCases(None))?;
    let covariance = covariance(&minimum, &held);
    let history = std::mem::take(&mut global.history);
    let profile = profile && minimum.ending != Ending::Stopped;
    let mut fit = answer(problem, global, &minimum, &covariance, (backend, profile));
    if fit.interrupted && minimum.ending != Ending::Stopped {
        fit.remarks.push(format!(
            "The run was interrupted before the intervals of {} were refined; they are from the quadratic approximation.",
            fit.affected.join(", ")
        ));
    }
    let count = problem.unknowns.len();
    let values = |x: &Vec<f64>| -> Vec<f64> {
        let unknowns = problem.unknowns.iter().zip(x);
        unknowns.map(|(unknown, x)| unknown.value(*x)).collect()
    };
    fit.history = std::iter::once(&initial)
        .chain(&history)
        .map(values)
        .collect();
    fit.history.dedup();
    // The written deck contains the identified parameters and no other fitted unknowns.
    let mut end = initial.clone();
    end[..count].copy_from_slice(&minimum.x[..count]);
    let [before, after] = [&initial, &end].map(|x| swept(global, x));
    fill(&mut fit, problem, &before, &after, 0);
    fit.held_out.curves = held_curves(problem, global, [&initial, &end]);
    fit.marks = marks(global, &minimum);
    fit.fit_test = tested(global, &minimum, &covariance, &mut fit.remarks);
    if fit.fit_test.is_some() {
        let left = Residuals::new(&global.observations.rows, &minimum, &covariance);
        fit.structure = lack_of_fit_tests(problem, &left);
    }
    fit.remarks.extend(left_out.iter().map(|case| {
        let label = &problem.measurement.cases[*case].label;
        format!("Load case {label} is left out: the solver finds no equilibrium for it.")
    }));
    let unstated = problem.measurement.channels.iter();
    fit.remarks.extend(
        unstated
            .filter(|channel| channel.sigma_estimated)
            .map(|channel| {
                let unit = channel.unit.as_deref().map_or_else(String::new, |unit| format!(" {unit}"));
                format!(
                    "The noise of {} is not stated; the residuals of the fit give a standard deviation of {:.3}{unit}.",
                    channel.name, channel.sigma
                )
            }),
    );
    Ok(Found {
        fit,
        minimum,
        covariance,
    })
}

/// Fits from each start in turn until a fit converges, and returns the best minimum. If the residuals are still much larger than the noise, a
/// further fit starts from the result of [`homotopy_start`].
fn attempt(global: &mut GlobalProblem<'_>, starts: &[Vec<f64>]) -> Option<Minimum> {
    let mut best: Option<Minimum> = None;
    for (at, start) in starts.iter().enumerate() {
        let done = best
            .as_ref()
            .is_some_and(|found| matches!(found.ending, Ending::Converged | Ending::Stopped));
        if done || starts[..at].contains(start) {
            break;
        }
        best = better(global, start, best);
    }
    let missed = best.as_ref().is_some_and(|found| {
        let rows = found.evaluation.residual.len() as f64;
        2.0 * found.objective > FAR_FIT_RMS_SIGMA * FAR_FIT_RMS_SIGMA * rows
            && found.ending != Ending::Stopped
    });
    if let (true, Some(last)) = (missed, starts.last()) {
        let (scale, held) = (global.scale(), global.held());
        let history = global.history.clone();
        let led = homotopy_start(global, last, &scale, &held);
        global.history = history;
        best = better(global, &led, best);
    }
    best
}

/// Minimises the objective from `start`. Returns the better of the new minimum and the known minimum. The history in `global` belongs to the
/// returned minimum.
fn better(
    global: &mut GlobalProblem<'_>,
    start: &[f64],
    known: Option<Minimum>,
) -> Option<Minimum> {
    let (priors, scale, held) = (global.priors(), global.scale(), global.held());
    let history = vec![start[..global.unknowns.len()].to_vec()];
    let before = std::mem::replace(&mut global.history, history);
    let found = minimise(global, start, &priors, &scale, &held, Tolerances::default());
    match (found, known) {
        (Some(found), Some(known)) if found.objective >= known.objective => {
            global.history = before;
            Some(known)
        }
        (Some(found), _) => Some(found),
        (None, known) => {
            global.history = before;
            known
        }
    }
}

/// Returns the cases among `cases` that have no equilibrium at the unknowns `x`.
fn unreached(global: &mut GlobalProblem<'_>, x: &[f64], cases: &[usize]) -> Vec<usize> {
    let numbers = global.unknowns.numbers(&global.deck, x);
    let prediction = global.predictor.predict(&numbers, None);
    let cases = cases.iter().copied();
    cases.filter(|case| prediction[*case].is_none()).collect()
}

/// Solves all load cases at the unknowns `x`.
fn swept(global: &mut GlobalProblem<'_>, x: &[f64]) -> Sweep {
    let numbers = global.unknowns.numbers(&global.deck, x);
    let of = |prediction: Option<CasePrediction>| match prediction {
        Some(prediction) => Ok(Equilibrium {
            time: 0.0,
            poses: prediction.poses,
        }),
        None => Err(CaseFailure::NoStep { message: None }),
    };
    Sweep {
        cases: global
            .predictor
            .predict(&numbers, None)
            .into_iter()
            .map(of)
            .collect(),
    }
}

fn answer(
    problem: &Problem<'_>,
    global: &mut GlobalProblem<'_>,
    minimum: &Minimum,
    covariance: &DMatrix<f64>,
    (backend, profile): (&str, bool),
) -> Fit {
    let count = problem.unknowns.len();
    let (priors, scale, held) = (global.priors(), global.scale(), global.held());
    let mut parameters = Vec::with_capacity(count);
    // Parameters whose value or interval a complete run would still have changed.
    let mut unrefined = Vec::new();
    for (k, unknown) in problem.unknowns.iter().enumerate() {
        let (x, sd) = (minimum.x[k], covariance[(k, k)].max(0.0).sqrt());
        let value = unknown.value(x);
        let normal =
            [-1.0, 1.0].map(|side| Some(unknown.value(x + side * NORMAL_QUANTILE_975 * sd)));
        let poor = profile && sd > POOR_NORMAL_LN_SD;
        let refined = (poor && global.goes_on(minimum))
            .then(|| profile_interval(global, minimum, k, covariance, &priors, &scale, &held))
            .filter(|_| global.goes_on(minimum));
        if minimum.ending == Ending::Stopped || (poor && refined.is_none()) {
            unrefined.push(unknown.address.to_string());
        }
        let interval95 = refined.map_or(normal, |sides| {
            sides.map(|side| side.map(|x| unknown.value(x)))
        });
        let correlation = (0..count)
            .filter(|&j| j != k)
            .map(|j| covariance[(k, j)] / (sd * covariance[(j, j)].max(0.0).sqrt()))
            .filter(|r| r.is_finite())
            .max_by(|a, b| a.abs().total_cmp(&b.abs()));
        parameters.push(ParameterFit {
            address: unknown.address.to_string(),
            tied: unknown.tied().iter().map(ToString::to_string).collect(),
            numbers: NumberFit::of(unknown, value),
            form: unknown.form(),
            unit: unknown.unit.clone(),
            initial: unknown.initial,
            value,
            std_error: Some(unknown.value_rate(x) * sd),
            interval95,
            correlation,
            tolerance_share: None,
            profile95: None,
            bootstrap: None,
            posterior: None,
            status: if unknown.is_at_bound(x, priors[k].mean) {
                Status::Bound
            } else if sd > UNIDENTIFIABLE_LN_SD {
                Status::Unidentifiable
            } else {
                Status::Identified
            },
        });
    }
    let unidentifiable_directions = open_directions(covariance, count, UNIDENTIFIABLE_LN_SD)
        .into_iter()
        .map(|open| UnidentifiableDirection {
            combination: open
                .weights
                .iter()
                .map(|(k, weight)| (problem.unknowns[*k].address.to_string(), *weight))
                .collect::<BTreeMap<_, _>>(),
            sd_log: open.sd,
        })
        .collect();
    let converged = minimum.ending == Ending::Converged;
    let mut remarks = Vec::new();
    if share_a_spline(&problem.unknowns) {
        remarks.push(
            "Each smooth change of a SPLINE is in addition to the changes above it; the identified deck contains the resulting curve."
                .to_string(),
        );
    }
    match minimum.ending {
        Ending::Converged => {}
        Ending::Stopped => {
            remarks.push("The fit was stopped; these are the values it had reached.".to_string());
        }
        Ending::MaxIterations | Ending::Stalled | Ending::NoAnswer => {
            remarks.push(NOT_CONVERGED.to_string());
        }
    }
    Fit {
        method: Method::GaussNewton.as_str().to_string(),
        backend: backend.to_string(),
        converged,
        interrupted: minimum.ending == Ending::Stopped || !unrefined.is_empty(),
        affected: unrefined,
        iterations: minimum.iterations,
        solver_runs: global.predictor.solver_runs(),
        balance: global.predictor.balance().cloned(),
        parameters,
        assembly_offsets: offsets(problem, global, minimum, covariance),
        unidentifiable_directions,
        remarks,
        ..Fit::default()
    }
}

/// Returns the fitted assembly offsets of each identified bushing; empty if the fit has no offsets.
fn offsets(
    problem: &Problem<'_>,
    global: &GlobalProblem<'_>,
    minimum: &Minimum,
    covariance: &DMatrix<f64>,
) -> Vec<OffsetFit> {
    let catalogue = global.predictor.system().catalogue();
    let mut found: Vec<OffsetFit> = problem
        .bushings()
        .into_iter()
        .map(|bushing| OffsetFit {
            address: format!("BUSHING/{}", problem.model.bushings[bushing].header.id),
            delta: [0.0; 6],
            std_error: [None; 6],
        })
        .collect();
    let mut any = false;
    for (k, unknown) in global.unknowns.list().iter().enumerate() {
        let UnknownTarget::Offset(component) = &unknown.target else {
            continue;
        };
        any = true;
        let address = catalogue.info(component.stiffness).address;
        let rotational = address.argument.as_deref() == Some("KT");
        let axis = address.index.unwrap_or(1) - 1 + if rotational { 3 } else { 0 };
        let id = address.id.map(|id| format!("BUSHING/{id}"));
        if let Some(offset) = found
            .iter_mut()
            .find(|offset| Some(&offset.address) == id.as_ref())
        {
            offset.delta[axis] = minimum.x[k];
            offset.std_error[axis] = Some(covariance[(k, k)].max(0.0).sqrt());
        }
    }
    if any { found } else { Vec::new() }
}

/// Returns the residual statistics of the marks. The degrees of freedom of the fit are distributed evenly over all rows.
fn marks(global: &GlobalProblem<'_>, minimum: &Minimum) -> Option<Marks> {
    let observations = &global.observations;
    let of_marks = |row: &Row| matches!(row, Row::Mark { .. });
    let squares: Vec<f64> = observations
        .rows
        .iter()
        .zip(minimum.evaluation.residual.iter())
        .filter(|(row, _)| of_marks(row))
        .map(|(_, r)| r * r)
        .collect();
    if squares.is_empty() {
        return None;
    }
    let sum: f64 = squares.iter().sum();
    let dof =
        effective_dof(global, minimum) * squares.len() as f64 / observations.rows.len() as f64;
    Some(Marks {
        rms: Some((sum / squares.len() as f64).sqrt() * observations.sigma),
        chi2_per_dof: (observations.measurement().sigma > 0.0).then(|| sum / dof.max(1.0)),
        sigma: observations.measurement().sigma,
    })
}

/// Computes the chi-square test of all residuals of a fit. With Huber's loss, outliers are excluded from the test and counted in a remark.
fn tested(
    global: &GlobalProblem<'_>,
    minimum: &Minimum,
    covariance: &DMatrix<f64>,
    remarks: &mut Vec<String>,
) -> Option<FitTest> {
    let observations = &global.observations;
    let measurement = observations.measurement();
    let mut tally = Tally::default();
    let mut outliers = 0;
    let r = &minimum.evaluation.residual;
    let beyond = |count: f64| {
        let far = ChiSquared::new(count).map_or(f64::INFINITY, |chi2| {
            chi2.inverse_cdf(1.0 - OUTLIER_FALSE_ALARM / r.len() as f64)
        });
        if global.loss == Loss::Huber {
            far
        } else {
            f64::INFINITY
        }
    };
    let (of_three, of_one) = (beyond(3.0), beyond(1.0));
    for (at, row) in observations.rows.iter().enumerate() {
        let (kind, count, far) = match *row {
            Row::Mark { axis: 0, .. } if measurement.sigma > 0.0 => {
                (ReadingKind::Marks, 3, of_three)
            }
            Row::Mark { .. } => continue,
            Row::Wheel {
                component: 0..=2, ..
            } => (ReadingKind::WheelPosition, 1, of_one),
            Row::Wheel { .. } => (ReadingKind::WheelAngles, 1, of_one),
            Row::Channel { channel, .. } => (ReadingKind::Channel(channel), 1, of_one),
        };
        let squares = r.rows(at, count).norm_squared();
        if squares > far {
            outliers += 1;
        } else {
            tally.add(kind, squares, count);
        }
    }
    if outliers > 0 {
        let (are, them) = if outliers == 1 {
            ("reading is an outlier", "it")
        } else {
            ("readings are outliers", "them")
        };
        remarks.push(format!(
            "{outliers} {are}, too far from the fit for the stated noise. The goodness-of-fit test leaves {them} out; loss = \"huber\" reduces the weight of outliers."
        ));
    }
    let (mut chi2, count) = tally.total();
    let mut dof = count as f64 - minimum.evaluation.free.len() as f64;
    let identified = global
        .unknowns
        .list()
        .iter()
        .map(|unknown| !matches!(unknown.target, UnknownTarget::Offset(_)));
    let identified = identified.chain(std::iter::repeat(false));
    for ((k, prior), is_identified) in global.priors().iter().enumerate().zip(identified) {
        if is_identified {
            dof -= (1.0 - covariance[(k, k)] / prior.sd.powi(2)).clamp(0.0, 1.0);
        } else if prior.sd > 0.0 {
            chi2 += 2.0 * prior.cost(minimum.x[k]);
        }
    }
    FitTest::new(chi2, dof, tally.kinds(measurement))
}

/// Returns the degrees of freedom of a fit: the number of rows minus the effective number of unknowns. The effective number of unknowns is the
/// trace of the information of the readings times the posterior covariance.
pub(crate) fn effective_dof(global: &GlobalProblem<'_>, minimum: &Minimum) -> f64 {
    let rows = (global.observations.rows.len() - minimum.evaluation.free.len()) as f64;
    let covariance = covariance(minimum, &global.held());
    let prior: f64 = global
        .priors()
        .iter()
        .enumerate()
        .filter(|(_, prior)| prior.sd.is_finite() && prior.sd > 0.0)
        .map(|(k, prior)| covariance[(k, k)] / (prior.sd * prior.sd))
        .sum();
    let free = global.held().iter().filter(|held| !**held).count() as f64;
    (rows - (free - prior)).max(1.0)
}
