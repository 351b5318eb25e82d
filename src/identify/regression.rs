//! `method = "regression"`: the iteration of the paper by Meissonnier et al. (section 3, equations 12 to 18). The model gives the force of each
//! bushing component, the measurement its deflection. The slope of a straight line through the (deflection, force) pairs is the new stiffness.
//! This is repeated until the stiffnesses no longer change. Equation numbers refer to the paper.

use std::ops::ControlFlow;

use super::evaluation::{fill, marker_pose};
use super::{Fit, IdentifyError, OffsetFit, ParameterFit, Place, Problem, Progress, Status};
use admire_session::backend::{Backend, Sweep};
use admire_solver::mechanics::{Pose, RelativeMotion, Vec3, Vec6};
use admire_study::deflection::{DeflectionForm, deflection};
use admire_study::settings::{Method, RegressionSettings, Slope, Weights};

/// Interpretation of equations 5, 6 and 10 of the paper. The default is the corrected interpretation; the alternatives demonstrate the effect
/// of misprints.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct EquationInterpretation {
    /// Form of equations 5 and 6 for the deflection.
    pub deflection: DeflectionForm,
    /// If true, the force is the one on the I marker, as ADAMS reports it. Every correlation r then changes its sign, so no stiffness passes the
    /// test against `r_min`.
    pub force_on_i: bool,
    /// If true, the torque is taken about the origin of J, so it includes `delta x F`.
    pub torque_at_j: bool,
}

/// Regression line through (deflection, force) pairs of one bushing component, by equations 13 to 15.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Line {
    /// Slope of the line, which is the stiffness.
    pub stiffness: f64,
    /// Deflection at zero force, delta0 of equation 12: mean(delta) - mean(F) / K. The paper prints equation 13 with the opposite sign.
    pub offset: f64,
    /// Correlation coefficient of force and deflection, equation 15.
    pub r: f64,
    /// Sum of (F - mean F)^2, from which the weight in equation 16 is computed.
    pub force_squares: f64,
    /// Number of (deflection, force) pairs.
    pub count: usize,
}

/// Fits a regression line to (deflection, force) pairs. Returns `None` for fewer than three pairs, or if deflection or force does not vary.
pub fn line(pairs: &[(f64, f64)], slope: Slope) -> Option<Line> {
    let count = pairs.len();
    if count < 3 {
        return None;
    }
    let n = count as f64;
    let mean_delta = pairs.iter().map(|(delta, _)| delta).sum::<f64>() / n;
    let mean_force = pairs.iter().map(|(_, force)| force).sum::<f64>() / n;
    let (mut dd, mut df, mut ff) = (0.0, 0.0, 0.0);
    for (delta, force) in pairs {
        let (d, f) = (delta - mean_delta, force - mean_force);
        dd += d * d;
        df += d * f;
        ff += f * f;
    }
    if dd <= 0.0 || ff <= 0.0 {
        return None;
    }
    let stiffness = match slope {
        Slope::Printed => df / dd,
        Slope::Inverse => ff / df,
    };
    Some(Line {
        stiffness,
        offset: mean_delta - mean_force / stiffness,
        r: df / (dd * ff).sqrt(),
        force_squares: ff,
        count,
    })
}

/// Extrapolation of the iteration to its fixed point, separately for each unknown.
#[derive(Clone, PartialEq, Debug)]
pub struct FixedPointPrediction {
    /// Predicted change of ln K from the last iteration to the fixed point, if the steps of the unknown continue to shrink at the present rate.
    /// `None` if the steps do not shrink.
    pub remaining: Vec<Option<f64>>,
    /// Ratio of successive steps of the unknown, averaged over the last steps; `None` if it cannot be estimated.
    pub rate: Vec<Option<f64>>,
}

/// Predicts the fixed point of the iteration. The rate at which the steps of each unknown shrink is estimated from its last steps; the
/// remaining steps then form a geometric series. `history` holds the values of all unknowns after each iteration.
pub fn predict(history: &[Vec<f64>]) -> FixedPointPrediction {
    let count = history.first().map_or(0, Vec::len);
    let (mut remaining, mut rate) = (vec![None; count], vec![None; count]);
    for k in 0..count {
        let steps: Vec<f64> = history
            .windows(2)
            .map(|pair| libm::log(pair[1][k] / pair[0][k]))
            .collect();
        let Some(&last) = steps.last() else { continue };
        if last == 0.0 {
            remaining[k] = Some(0.0);
            continue;
        }
        // The rate is averaged over up to five steps, because a single ratio is unreliable while several modes decay.
        let span = (steps.len() - 1).min(5);
        let first = steps[steps.len() - 1 - span];
        if span == 0 || first * last <= 0.0 {
            continue;
        }
        let ratio = libm::pow(last / first, 1.0 / span as f64);
        rate[k] = Some(ratio);
        if ratio < 1.0 {
            remaining[k] = Some(last * ratio / (1.0 - ratio));
        }
    }
    FixedPointPrediction { remaining, rate }
}

/// Returns the measured deflection of each bushing in each fitted case, as `[bushing][case]`. The entry is `None` if the pose of one of the two
/// parts is not measured.
fn measured_deflections(
    problem: &Problem<'_>,
    bushings: &[usize],
    form: DeflectionForm,
) -> Vec<Vec<Option<Vec6>>> {
    let (model, measurement) = (problem.model, problem.measurement);
    let mut found = vec![vec![None; measurement.cases.len()]; bushings.len()];
    for case in measurement.fitted_cases() {
        let poses = measurement.poses(case, model);
        for (at, &bushing) in bushings.iter().enumerate() {
            let law = &model.bushings[bushing];
            let [i, j] = [law.i, law.j].map(|marker| {
                let frame = &model.markers[marker.0];
                let local = Pose {
                    p: frame.qp,
                    R: frame.R,
                };
                poses[frame.part.0].as_ref().map(|fit| (fit.pose, local))
            });
            if let (Some((part_i, i)), Some((part_j, j))) = (i, j) {
                found[at][case] = Some(deflection(&part_i, &i, &part_j, &j, form));
            }
        }
    }
    found
}

/// Computes the force and torque of a bushing, exerted by part 1 (marker I) on part 2 (marker J) in J axes (equation 10). They follow from the
/// part poses by the BUSHING law.
fn bushing_force(
    problem: &Problem<'_>,
    bushing: usize,
    stiffness: &[f64; 6],
    poses: &[Pose],
    reading: EquationInterpretation,
) -> Vec6 {
    let law = &problem.model.bushings[bushing];
    let i = marker_pose(problem.model, poses, law.i);
    let j = marker_pose(problem.model, poses, law.j);
    let motion = RelativeMotion::between(&i, &j, &Vec3::zeros());
    let (d, a) = (motion.p_ij_j, motion.angles);
    // The force on I is F = -K d + F0. The force on J is the opposite. Its torque about the origin of J additionally contains d x F.
    let mut wrench = Vec6::zeros();
    for k in 0..3 {
        wrench[k] = stiffness[k] * d[k] - law.force[k];
        wrench[k + 3] = stiffness[k + 3] * a[k] - law.torque[k];
    }
    if reading.torque_at_j {
        let force = Vec3::new(wrench[0], wrench[1], wrench[2]);
        let moved = d.cross(&force);
        for k in 0..3 {
            wrench[k + 3] += moved[k];
        }
    }
    if reading.force_on_i { -wrench } else { wrench }
}

/// Identifies bushing stiffnesses by the iteration of the paper, with any backend.
///
/// Unknowns other than bushing stiffnesses keep their initial values, because the iteration has no regression line for them.
///
/// # Errors
/// Returns [`IdentifyError`] if there are no unknowns or no marks, or if the first sweep provides no usable case. If the backend fails later,
/// the iteration ends, and the result with the values reached is marked as not converged.
pub fn identify(
    problem: &Problem<'_>,
    backend: &mut dyn Backend,
    progress: &mut Progress<'_>,
) -> Result<Fit, IdentifyError> {
    identify_as(
        problem,
        backend,
        EquationInterpretation::default(),
        progress,
    )
}

/// Identifies bushing stiffnesses by the iteration of the paper, with a chosen interpretation of the printed equations.
///
/// # Errors
/// See [`identify`].
pub fn identify_as(
    problem: &Problem<'_>,
    backend: &mut dyn Backend,
    reading: EquationInterpretation,
    progress: &mut Progress<'_>,
) -> Result<Fit, IdentifyError> {
    if problem.unknowns.is_empty() {
        return Err(IdentifyError::NoUnknowns);
    }
    if problem.measurement.parts.is_empty() {
        return Err(IdentifyError::NotPossible {
            method: Method::Regression.as_str(),
            needs: "marks on the parts",
        });
    }
    if problem.changes_numbers() {
        return Err(IdentifyError::NotPossible {
            method: Method::Regression.as_str(),
            needs: "unknowns of form = \"value\", not changes or factors",
        });
    }
    let settings = problem.regression;
    let bushings = problem.bushings();
    let deltas = measured_deflections(problem, &bushings, reading.deflection);
    let mut values = problem.initial();
    let mut history = vec![values.clone()];
    let mut remarks = Vec::new();
    let before = problem.sweep(backend, &values)?;
    let usable = |sweep: &Sweep| {
        let mut cases = problem.measurement.fitted_cases();
        cases.any(|case| sweep.equilibrium(case).is_some())
    };
    if !usable(&before) {
        let why = before
            .cases
            .iter()
            .find_map(|outcome| outcome.as_ref().err().cloned());
        return Err(IdentifyError::NoCases(why));
    }
    let mut sweep = before.clone();
    let mut sweeps = 1;
    let (mut converged, mut interrupted) = (false, false);
    let mut lines = Vec::new();
    while history.len() <= settings.max_iterations {
        lines = all_lines(problem, &bushings, &deltas, &sweep, &values, reading);
        let (next, _) = step(problem, &bushings, &lines, &values, settings);
        let change = largest_change(&values, &next);
        converged = within_step_test(&values, &next, settings.epsilon);
        values = next;
        history.push(values.clone());
        let stopped = progress(history.len() - 1, &values, change) == ControlFlow::Break(());
        interrupted = stopped && !converged;
        if interrupted {
            remarks.push("The run was stopped before the step test was met.".to_string());
        }
        if converged || stopped {
            break;
        }
        match problem.sweep(backend, &values) {
            Ok(next) if usable(&next) => sweep = next,
            Ok(_) => {
                remarks.push(
                    "The run ended because no load case has an equilibrium with the next values."
                        .to_string(),
                );
                break;
            }
            Err(error) => {
                remarks.push(format!("The run ended because the solver failed: {error}."));
                break;
            }
        }
        sweeps += 1;
    }
    // The equilibria at the final values have not been solved yet. If they cannot be solved, the last sweep is used instead.
    let after = problem.sweep(backend, &values).unwrap_or(sweep);
    sweeps += 1;
    remarks.extend(stagnation(problem, &history, converged, settings));
    remarks.extend(unreachable(problem, &after));
    let (_, kept) = step(problem, &bushings, &lines, &values, settings);
    let mut fit = Fit {
        method: Method::Regression.as_str().to_string(),
        backend: backend.name().to_string(),
        converged,
        iterations: history.len() - 1,
        solver_runs: sweeps * problem.programme.cases.len(),
        balance: backend.balance().cloned(),
        parameters: parameters(problem, &bushings, &lines, &values, &kept),
        assembly_offsets: offsets(problem, &bushings, &lines),
        history,
        remarks,
        ..Fit::default()
    };
    fill(&mut fit, problem, &before, &after, problem.unknowns.len());
    if interrupted {
        fit.cut_short();
    }
    Ok(fit)
}

type Lines = Vec<[Option<Line>; 6]>;

fn all_lines(
    problem: &Problem<'_>,
    bushings: &[usize],
    deltas: &[Vec<Option<Vec6>>],
    sweep: &Sweep,
    values: &[f64],
    reading: EquationInterpretation,
) -> Lines {
    let mut lines = Vec::with_capacity(bushings.len());
    for (at, &bushing) in bushings.iter().enumerate() {
        let stiffness = problem.stiffnesses(bushing, values);
        let mut pairs: [Vec<(f64, f64)>; 6] = Default::default();
        for case in problem.measurement.fitted_cases() {
            if let (Some(delta), Some(equilibrium)) = (&deltas[at][case], sweep.equilibrium(case)) {
                let poses = &equilibrium.poses;
                let force = bushing_force(problem, bushing, &stiffness, poses, reading);
                for axis in 0..6 {
                    pairs[axis].push((delta[axis], force[axis]));
                }
            }
        }
        lines.push(pairs.map(|pairs| line(&pairs, problem.regression.slope)));
    }
    lines
}

/// Returns the next values of the unknowns (equations 13, 15, 16), and for each unknown whether it keeps its previous value.
fn step(
    problem: &Problem<'_>,
    bushings: &[usize],
    lines: &Lines,
    values: &[f64],
    settings: &RegressionSettings,
) -> (Vec<f64>, Vec<bool>) {
    let mut next = values.to_vec();
    let mut kept = vec![true; values.len()];
    for (at, unknown) in problem.unknowns.iter().enumerate() {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (bushing, axis) in unknown.axes() {
            let place = bushings.iter().position(|of| *of == bushing);
            let Some(line) = place.and_then(|place| lines[place][axis]) else {
                continue;
            };
            if line.r > settings.r_min && line.stiffness > 0.0 && line.stiffness.is_finite() {
                let weight = match settings.weights {
                    Weights::Printed => 1.0 / line.force_squares,
                    Weights::Corrected => line.force_squares,
                };
                sum += weight * line.stiffness;
                weights += weight;
            }
        }
        if weights > 0.0 {
            next[at] = sum / weights;
            kept[at] = false;
        }
    }
    (next, kept)
}

/// Returns true if every unknown passes the step test of equation 17: its relative change is below `epsilon`.
fn within_step_test(before: &[f64], after: &[f64], epsilon: f64) -> bool {
    before.iter().zip(after).all(|(before, after)| {
        let ratio = after / before;
        1.0 - epsilon < ratio && ratio < 1.0 + epsilon
    })
}

fn largest_change(before: &[f64], after: &[f64]) -> f64 {
    let change = |(before, after): (&f64, &f64)| (after / before - 1.0).abs();
    before.iter().zip(after).map(change).fold(0.0, f64::max)
}

/// Returns a remark for each unknown that is still far from its fixed point although the step test has passed. Equation 17 tests for small
/// steps, not for convergence.
fn stagnation(
    problem: &Problem<'_>,
    history: &[Vec<f64>],
    converged: bool,
    settings: &RegressionSettings,
) -> Vec<String> {
    if !converged {
        return Vec::new();
    }
    let prediction = predict(history);
    let mut remarks = Vec::new();
    for (k, unknown) in problem.unknowns.iter().enumerate() {
        let Some(remaining) = prediction.remaining[k] else {
            continue;
        };
        // A remaining change of up to three times the tolerance is consistent with the test.
        if remaining.abs() > 3.0 * settings.epsilon {
            let rate = prediction.rate[k].unwrap_or(0.0);
            remarks.push(format!(
                "The step test of equation 17 was met while {} still changes. The steps shrink only by a factor of {rate:.3}, so a \
                 further change by a factor of about {:.2} is to be expected.",
                unknown.address,
                libm::exp(remaining)
            ));
        }
    }
    remarks
}

/// Returns a remark for each load case without an equilibrium. Such cases are left out of the regression lines.
fn unreachable(problem: &Problem<'_>, sweep: &Sweep) -> Vec<String> {
    let mut remarks = Vec::new();
    for (case, outcome) in problem.programme.cases.iter().zip(&sweep.cases) {
        if let Err(failure) = outcome {
            remarks.push(format!("Load case {} is left out: {failure}.", case.label));
        }
    }
    remarks
}

fn parameters(
    problem: &Problem<'_>,
    bushings: &[usize],
    lines: &Lines,
    values: &[f64],
    kept: &[bool],
) -> Vec<ParameterFit> {
    let mut parameters = Vec::with_capacity(values.len());
    for (at, unknown) in problem.unknowns.iter().enumerate() {
        let found: Vec<Line> = unknown
            .axes()
            .into_iter()
            .filter_map(|(bushing, axis)| {
                let place = bushings.iter().position(|of| *of == bushing)?;
                lines.get(place)?[axis]
            })
            .collect();
        // The standard error follows from the scatter about the line. For tied stiffnesses, the line with the highest correlation is used.
        let best = found.iter().copied().max_by(|a, b| a.r.total_cmp(&b.r));
        let identified = !kept[at] && unknown.place != Place::Number;
        let std_error = best.filter(|_| identified).map(|line| {
            let scatter = (1.0 / (line.r * line.r) - 1.0).max(0.0);
            values[at] * (scatter / (line.count as f64 - 2.0)).sqrt()
        });
        let half = best.map(|line| student_t(line.count - 2));
        let interval95 = match (std_error, half) {
            (Some(error), Some(t)) => {
                let low = values[at] - t * error;
                [(low > 0.0).then_some(low), Some(values[at] + t * error)]
            }
            _ => [None, None],
        };
        parameters.push(ParameterFit {
            address: unknown.address.to_string(),
            tied: unknown.tied().iter().map(ToString::to_string).collect(),
            numbers: Vec::new(),
            form: None,
            unit: unknown.unit.clone(),
            initial: unknown.initial,
            value: values[at],
            std_error,
            interval95,
            correlation: best.map(|line| line.r),
            tolerance_share: None,
            profile95: None,
            bootstrap: None,
            posterior: None,
            status: if identified {
                Status::Identified
            } else {
                Status::Unidentifiable
            },
        });
    }
    parameters
}

/// Returns the 97.5 percent quantile of the Student t distribution, for two-sided 95 percent intervals.
fn student_t(dof: usize) -> f64 {
    use statrs::distribution::{ContinuousCDF, StudentsT};
    let distribution = StudentsT::new(0.0, 1.0, dof.max(1) as f64);
    distribution.map_or(2.0, |t| t.inverse_cdf(0.975))
}

fn offsets(problem: &Problem<'_>, bushings: &[usize], lines: &Lines) -> Vec<OffsetFit> {
    let mut offsets = Vec::new();
    for (place, &bushing) in bushings.iter().enumerate() {
        let Some(lines) = lines.get(place) else {
            continue;
        };
        let usable = |line: &Option<Line>| line.filter(|line| line.r > problem.regression.r_min);
        let id = problem.model.bushings[bushing].header.id;
        let mut offset = OffsetFit {
            address: format!("BUSHING/{id}"),
            delta: [0.0; 6],
            std_error: [None; 6],
        };
        for axis in 0..6 {
            if let Some(line) = usable(&lines[axis]) {
                offset.delta[axis] = line.offset;
                // The standard error of the offset: the scatter of one deflection about the line, divided by the square root of the number of
                // cases.
                let n = line.count as f64;
                let spread = line.force_squares / n * (1.0 / (line.r * line.r) - 1.0).max(0.0);
                offset.std_error[axis] = Some((spread / n).sqrt() / line.stiffness);
            }
        }
        offsets.push(offset);
    }
    offsets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_and_its_intercept() {
        let pairs: Vec<(f64, f64)> = (0..7)
            .map(|k| f64::from(k) / 10.0)
            .map(|d| (d, 500.0 * (d - 0.2)))
            .collect();
        for slope in [Slope::Printed, Slope::Inverse] {
            let line = line(&pairs, slope).unwrap();
            assert!((line.stiffness - 500.0).abs() < 1e-9);
            assert!((line.offset - 0.2).abs() < 1e-12);
            assert!((line.r - 1.0).abs() < 1e-12);
        }
        assert!(line(&pairs[..2], Slope::Printed).is_none());
    }

    #[test]
    fn noise_on_the_deflection_biases_the_printed_slope_by_r_squared() {
        // Note 7 of the guide page `paper`. The noise of the deflection is half its standard deviation, so r^2 = 1 / 1.25.
        let mut noise = admire_study::noise::Noise::new(5, "attenuation");
        let pairs: Vec<(f64, f64)> = (0..100_000)
            .map(|_| {
                let delta = noise.normal();
                (delta + 0.5 * noise.normal(), 1000.0 * delta)
            })
            .collect();
        let printed = line(&pairs, Slope::Printed).unwrap();
        let inverse = line(&pairs, Slope::Inverse).unwrap();
        assert!((printed.stiffness / 1000.0 - 0.8).abs() < 0.01);
        assert!((inverse.stiffness / 1000.0 - 1.0).abs() < 0.01);
        assert!((printed.r.powi(2) - 0.8).abs() < 0.01);
    }

    #[test]
    fn a_geometric_approach_is_extrapolated() {
        // The history is ln K_n = 2 + 0.9^n, so a change of 0.9^30 = 0.0424 remains after 30 steps.
        let history: Vec<Vec<f64>> = (0..=30)
            .map(|n| vec![(2.0 + 0.9_f64.powi(n)).exp(), 5.0])
            .collect();
        let prediction = predict(&history);
        assert!((prediction.rate[0].unwrap() - 0.9).abs() < 1e-9);
        assert!((prediction.remaining[0].unwrap() + 0.9_f64.powi(30)).abs() < 1e-9);
        assert_eq!(prediction.remaining[1], Some(0.0));
    }
}
