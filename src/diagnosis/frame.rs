//! Measuring frame: effects of its shift and rotation on the mark readings, and its motion through the cases.

use std::f64::consts::PI;

use super::diagnosis_problem::DiagnosisProblem;
use crate::settings::FRAME_DRIFT_FUNCTIONS;
use admire_identify::global::gauss_newton::LeastSquares;
use admire_identify::global::{Observations, Prepared, Row, fit_unknowns, global_problem};
use admire_identify::tolerance::EffectGroup;
use admire_session::backend::LoadProgramme;
use admire_solver::mechanics::Vec3;
use admire_study::{Case, FramePlace};

/// Returns the changes of the mark rows of case `of` by a unit shift of the measuring frame along each axis, and by a unit rotation about
/// each axis. Each change is a pair of row index and value. The centre of rotation is the centroid of `places`, which are the positions of
/// the marks in that case. `unit` is the length of one row unit. `turn` is the angle of a unit rotation in radians.
pub fn by_frame(
    rows: &[Row],
    of: usize,
    places: &[Vec3],
    unit: f64,
    turn: f64,
) -> [Vec<(usize, f64)>; 6] {
    let mut columns: [Vec<(usize, f64)>; 6] = Default::default();
    let centre = centroid(places);
    for (at, row) in rows.iter().enumerate() {
        let Row::Mark {
            case,
            reading,
            axis,
        } = *row
        else {
            continue;
        };
        if case != of {
            continue;
        }
        let by = at_point(&(places[reading] - centre), turn);
        for (k, column) in columns.iter_mut().enumerate() {
            if by[k][axis] != 0.0 {
                column.push((at, by[k][axis] / unit));
            }
        }
    }
    columns
}

/// Returns the displacements of a point by three unit shifts and by three rotations of `turn` radians. `lever` points from the centre of
/// rotation to the point.
pub fn at_point(lever: &Vec3, turn: f64) -> [Vec3; 6] {
    std::array::from_fn(|k| match k.checked_sub(3) {
        None => Vec3::ith(k, 1.0),
        Some(k) => Vec3::ith(k, turn).cross(lever),
    })
}

/// Returns the mean of the given positions; zero for an empty list.
pub fn centroid(places: &[Vec3]) -> Vec3 {
    places.iter().sum::<Vec3>() / places.len().max(1) as f64
}

/// Returns true if the readings are in a measuring frame other than the deck's. At the start values of the fit, all marks of the fitted
/// cases are then offset by one common rigid motion.
pub(super) fn is_another(subject: &DiagnosisProblem<'_>) -> bool {
    let length = subject.problem.model.units.length.si;
    place_at_start(subject).is_some_and(|place| place.is_another(length))
}

/// Returns the rigid motion that carries the predicted to the measured mark positions, at the start values of the fit. Returns `None`
/// without marks, or if a case has no equilibrium at the start values.
fn place_at_start(subject: &DiagnosisProblem<'_>) -> Option<FramePlace> {
    if !subject.compares_marks() {
        return None;
    }
    let problem = &subject.problem;
    let prepared = Prepared::new(problem).ok()?;
    let cases: Vec<usize> = subject.cases_fitted().collect();
    let observations = Observations::new(problem.measurement, problem.model, &cases);
    let unknowns = fit_unknowns(problem, &prepared.system, None);
    let observed = observations.observed.clone();
    let predictor = prepared.native(problem, observed).ok()?;
    let mut global = global_problem(problem, observations, unknowns, Box::new(predictor));
    let start = global.start();
    let residual = global.evaluate(&start, false)?.residual;
    subject.count_sweeps(1);
    let predicted = global.observations.predicted(&residual);
    let of = |all: &[Case]| -> Vec<Vec3> {
        let marks = cases.iter().flat_map(|case| &all[*case].marks);
        marks.map(|mark| mark.x).collect()
    };
    FramePlace::of(&of(&predicted), &of(&problem.measurement.cases))
}

/// Motion of the measuring frame through the cases: its tolerance group, and one factor per case.
pub(super) type Motion = (EffectGroup, Vec<f64>);

/// Returns the motions of the measuring frame that the study's tolerances include. The factors cover the study's cases, and then further
/// cases with the loads `further`.
pub fn motions(subject: &DiagnosisProblem<'_>, further: &[&[f64]]) -> Vec<Motion> {
    let has = |group: EffectGroup| subject.compares_marks() && subject.sizes.group(group).is_some();
    let programme = subject.problem.programme;
    let count = programme.cases.len();
    let mut out = Vec::new();
    if has(EffectGroup::FrameAlignment) {
        out.push((
            EffectGroup::FrameAlignment,
            vec![1.0; count + further.len()],
        ));
    }
    if has(EffectGroup::FrameDrifts) {
        // The drift of the frame in a further case is unknown; its factor is zero.
        let of = |case: usize| {
            if case < count {
                drifts(case, count)
            } else {
                [0.0; FRAME_DRIFT_FUNCTIONS]
            }
        };
        let all: Vec<[f64; FRAME_DRIFT_FUNCTIONS]> = (0..count + further.len()).map(of).collect();
        let one = |k: usize| all.iter().map(|of| of[k]).collect();
        out.extend((0..FRAME_DRIFT_FUNCTIONS).map(|k| (EffectGroup::FrameDrifts, one(k))));
    }
    if has(EffectGroup::MountYield) {
        for (load, largest) in varying(programme) {
            let known = programme.cases.iter().map(|case| case.values[load]);
            let values = known.chain(further.iter().map(|values| values[load]));
            out.push((
                EffectGroup::MountYield,
                values.map(|value| value / largest).collect(),
            ));
        }
    }
    out
}

/// Returns the indices of the loads that vary between cases, each with its largest magnitude.
pub(super) fn varying(programme: &LoadProgramme) -> Vec<(usize, f64)> {
    let of = |load: usize| {
        let values = || programme.cases.iter().map(|case| case.values[load]);
        let largest = values().map(f64::abs).fold(0.0, f64::max);
        let first = values().next()?;
        values()
            .any(|value| value != first)
            .then_some((load, largest))
    };
    (0..programme.loads.len()).filter_map(of).collect()
}

/// Returns the leading Karhunen-Loeve functions of a random walk over `count` cases with unit step variance, evaluated in case `of`.
/// Function `k` is `sqrt(2 n) sin(w t / n) / w` with `w = (k - 1/2) pi`, where `n` is the number of cases and `t` counts the cases from one.
fn drifts(of: usize, count: usize) -> [f64; FRAME_DRIFT_FUNCTIONS] {
    let n = count as f64;
    std::array::from_fn(|k| {
        let w = (k as f64 + 0.5) * PI;
        (2.0 * n).sqrt() * libm::sin(w * (of + 1) as f64 / n) / w
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_functions_have_the_variance_of_a_random_walk() {
        for (case, least) in [(5, 0.8), (15, 0.9), (30, 0.95)] {
            let sum: f64 = drifts(case, 31).iter().map(|value| value * value).sum();
            let variance = (case + 1) as f64;
            assert!(sum > least * variance && sum < variance, "{case}: {sum}");
        }
    }
}
