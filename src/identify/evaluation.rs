use super::goodness::{FitTest, ReadingKind, Tally};
use super::{Fit, Marks, Problem, WheelFit, Written};
use admire_session::backend::Sweep;
use admire_solver::mechanics::Pose;
use admire_solver::model::{MarkerIx, Model};
use admire_study::Measurement;

/// Rms differences between the solutions of a sweep and the readings, over a set of load cases.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct ReadingMisfit {
    /// Rms difference per mark coordinate, over all marks; `None` without marks.
    pub marks_rms: Option<f64>,
    /// Number of mark coordinates that were compared.
    pub coordinates: usize,
    /// Rms differences of camber and steer, in degrees; `None` without wheel readings.
    pub wheel_deg_rms: Option<[f64; 2]>,
    /// Rms difference per coordinate of the wheel centre; `None` without wheel readings.
    pub wheel_position_rms: Option<f64>,
    /// Number of cases with wheel readings.
    pub wheels: usize,
}

/// Returns the pose of a marker in ground, given the poses of all parts.
pub fn marker_pose(model: &Model, poses: &[Pose], marker: MarkerIx) -> Pose {
    let frame = &model.markers[marker.0];
    let local = Pose {
        p: frame.qp,
        R: frame.R,
    };
    poses[frame.part.0].compose(&local)
}

/// Compares the solutions of a sweep with the readings of the given cases. Cases without an equilibrium are skipped.
pub fn compare(
    model: &Model,
    measurement: &Measurement,
    sweep: &Sweep,
    cases: impl Iterator<Item = usize>,
) -> ReadingMisfit {
    let (mut marks, mut coordinates) = (0.0, 0);
    let (mut angles, mut position, mut wheels) = ([0.0; 2], 0.0, 0);
    for case in cases {
        let Some(equilibrium) = sweep.equilibrium(case) else {
            continue;
        };
        for reading in &measurement.cases[case].marks {
            let marked = &measurement.parts[reading.part];
            let x = equilibrium.poses[marked.part.0].point(&marked.marks[reading.mark].p);
            marks += (x - reading.x).norm_squared();
            coordinates += 3;
        }
        if let (Some(wheel), Some(read)) = (&measurement.wheel, &measurement.cases[case].wheel) {
            let now = wheel
                .spin
                .reading(&marker_pose(model, &equilibrium.poses, wheel.marker));
            angles[0] += (now.camber_deg - read.camber_deg).powi(2);
            angles[1] += (now.steer_deg - read.steer_deg).powi(2);
            position += (now.position - read.position).norm_squared();
            wheels += 1;
        }
    }
    let rms = |sum: f64, count: usize| (count > 0).then(|| (sum / count as f64).sqrt());
    ReadingMisfit {
        marks_rms: rms(marks, coordinates),
        coordinates,
        wheel_deg_rms: rms(angles[0], wheels)
            .zip(rms(angles[1], wheels))
            .map(|(c, s)| [c, s]),
        wheel_position_rms: rms(position, 3 * wheels),
        wheels,
    }
}

/// Computes the chi-square test of the mark and wheel residuals in `found`. `parameters` is the number of unknowns that were estimated from
/// these readings; it reduces the degrees of freedom.
fn tested(problem: &Problem<'_>, found: &ReadingMisfit, parameters: usize) -> Option<FitTest> {
    let measurement = problem.measurement;
    let mut tally = Tally::default();
    let mut add = |kind: ReadingKind, rms: Option<f64>, count: usize, variance: f64| {
        if let Some(rms) = rms.filter(|_| variance > 0.0) {
            tally.add(kind, rms * rms * count as f64 / variance, count);
        }
    };
    // The variance of a mark coordinate also includes the position error of the mark on its part, from the first measuring session.
    let variance = measurement.sigma.powi(2) + measurement.sigma_on_parts.powi(2);
    add(
        ReadingKind::Marks,
        found.marks_rms,
        found.coordinates,
        variance,
    );
    if let Some(wheel) = &measurement.wheel {
        let variance = wheel.sigma_position.powi(2);
        add(
            ReadingKind::WheelPosition,
            found.wheel_position_rms,
            3 * found.wheels,
            variance,
        );
        let angles = found
            .wheel_deg_rms
            .map(|[a, b]| f64::midpoint(a * a, b * b).sqrt());
        add(
            ReadingKind::WheelAngles,
            angles,
            2 * found.wheels,
            wheel.sigma_angle_deg.powi(2),
        );
    }
    let (chi2, count) = tally.total();
    FitTest::new(
        chi2,
        count.saturating_sub(parameters) as f64,
        tally.kinds(measurement),
    )
}

/// Fills in the results of `fit` for marks, wheel and held-out readings. `before` and `after` are sweeps with the initial and with the
/// final values of the identified parameters. No other fitted unknowns are applied to the deck.
///
/// `parameters` is the number of unknowns that were estimated from the marks; it reduces the degrees of freedom.
pub(crate) fn fill(
    fit: &mut Fit,
    problem: &Problem<'_>,
    before: &Sweep,
    after: &Sweep,
    parameters: usize,
) {
    let measurement = problem.measurement;
    let fitted = over(problem, after, false);
    fit.fit_test = tested(problem, &fitted, parameters);
    fit.marks = fitted.marks_rms.map(|rms| {
        let dof = fitted.coordinates.saturating_sub(parameters).max(1) as f64;
        // The variance of a mark coordinate also includes the position error of the mark on its part, from the first measuring session.
        let variance = measurement.sigma.powi(2) + measurement.sigma_on_parts.powi(2);
        let squares = rms * rms * fitted.coordinates as f64;
        Marks {
            rms: Some(rms),
            chi2_per_dof: (variance > 0.0).then(|| squares / variance / dof),
            sigma: measurement.sigma,
        }
    });
    written(fit, problem, before, after);
}

/// Compares a sweep with the readings of the held-out cases if `held_out` is true, otherwise with the readings of the fitted cases.
fn over(problem: &Problem<'_>, sweep: &Sweep, held_out: bool) -> ReadingMisfit {
    let cases = &problem.measurement.cases;
    let chosen = (0..cases.len()).filter(|&case| cases[case].held_out == held_out);
    compare(problem.model, problem.measurement, sweep, chosen)
}

/// Fills in the results of `fit` that compare two plain decks with the readings: the deck with the initial and the deck with the identified
/// parameters, without other fitted unknowns.
pub fn written(fit: &mut Fit, problem: &Problem<'_>, before: &Sweep, after: &Sweep) {
    let measurement = problem.measurement;
    let of_fitted = [before, after].map(|sweep| over(problem, sweep, false).marks_rms);
    fit.written = of_fitted[0]
        .zip(of_fitted[1])
        .map(|(before, after)| Written {
            marks_rms_before: before,
            marks_rms_after: after,
        });
    let labels = measurement.cases.iter().filter(|case| case.held_out);
    fit.held_out.cases = labels.map(|case| case.label.clone()).collect();
    fit.held_out.marks_rms_before = over(problem, before, true).marks_rms;
    fit.held_out.marks_rms_after = over(problem, after, true).marks_rms;
    let all = |sweep| {
        compare(
            problem.model,
            measurement,
            sweep,
            0..measurement.cases.len(),
        )
    };
    fit.wheel = all(before).wheel_deg_rms.zip(all(after).wheel_deg_rms).map(
        |([camber_before, steer_before], [camber_after, steer_after])| WheelFit {
            camber_deg_rms_before: camber_before,
            camber_deg_rms_after: camber_after,
            steer_deg_rms_before: steer_before,
            steer_deg_rms_after: steer_after,
        },
    );
}
