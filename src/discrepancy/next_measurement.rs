//! A load case in which two explanations that do equally well would differ most.

use std::collections::BTreeMap;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::diagnosis::NextMeasurement;
use super::fit::Fitted;
use super::hypothesis::Hypothesis;
use super::subject::Subject;
use crate::identify::Problem;
use crate::identify::global::{
    CasePrediction, Direction, FitUnknown, FitUnknowns, Meaning, Numbers, Observations, Predictor,
};
use crate::mechanics::Vec3;

/// What separates less than this does not.
const SEPARATED: f64 = 6.0;
/// Load cases that are looked at, at most.
const CANDIDATES: usize = 81;

/// The load case within the range of those applied that tells a finding from its rival, or the repetition of one where a single
/// reading is in question.
pub fn next_measurement(
    subject: &Subject<'_>,
    (best, finding): (&Fitted, &Hypothesis),
    (other, rival): (&Fitted, &Hypothesis),
) -> Option<NextMeasurement> {
    let names = |h: &Hypothesis| format!("{} {}", h.cause, h.address);
    let (a, b) = (names(finding), names(rival));
    let programme = subject.problem.programme;
    let case_of = |values: &[f64]| -> BTreeMap<String, f64> {
        // The programme is in radians where the column of the study is in degrees.
        let columns = programme.loads.iter().zip(values).map(|(load, value)| {
            let degrees = load.name.ends_with("_deg");
            let value = if degrees { value.to_degrees() } else { *value };
            (load.name.clone(), value)
        });
        columns.collect()
    };
    for hypothesis in [finding, rival] {
        if let Some(case) = hypothesis.only_case(&subject.rows) {
            return Some(NextMeasurement {
                case: case_of(&programme.cases[case].values),
                why: format!(
                    "repeating case {} separates {a} from {b}",
                    programme.cases[case].label
                ),
            });
        }
    }
    let candidates = candidates(subject);
    let mine = predict(subject, best, &candidates)?;
    let theirs = predict(subject, other, &candidates)?;
    let covariance = &best.posterior.covariance;
    let count = best.unknowns.len();
    let covariance = covariance.view((0, 0), (count, count)).into_owned();
    let mut found: Option<(f64, usize, String)> = None;
    for (k, (mine, theirs)) in mine.iter().zip(&theirs).enumerate() {
        let (Some(mine), Some(theirs)) = (mine, theirs) else {
            continue;
        };
        let difference = &mine.0 - &theirs.0;
        let J = &mine.1;
        let S =
            J * &covariance * J.transpose() + DMatrix::identity(difference.len(), difference.len());
        let separated = difference.dot(&Cholesky::new(S)?.solve(&difference));
        if found.as_ref().is_none_or(|(best, ..)| separated > *best) {
            let at = (0..difference.len() / 3)
                .max_by(|a, b| {
                    let size = |k: &usize| difference.rows(3 * k, 3).norm();
                    size(a).total_cmp(&size(b))
                })
                .unwrap_or_default();
            found = Some((separated, k, mark_name(subject, at)));
        }
    }
    let (separated, k, mark) = found?;
    let why = if separated > SEPARATED {
        format!(
            "separates {a} from {b} by a chi-square of about {separated:.1}, most at mark {mark}"
        )
    } else {
        format!(
            "separates {a} from {b} best of all loads in the range applied, but by a chi-square of {separated:.1} only: marks on both \
             sides of {} would tell",
            rival.address
        )
    };
    Some(NextMeasurement {
        case: case_of(&candidates[k]),
        why,
    })
}

/// Corners and middles of the box of all loads that were applied.
fn candidates(subject: &Subject<'_>) -> Vec<Vec<f64>> {
    let programme = subject.problem.programme;
    let mut out: Vec<Vec<f64>> = vec![Vec::new()];
    for load in 0..programme.loads.len() {
        let values: Vec<f64> = programme.cases.iter().map(|c| c.values[load]).collect();
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut levels = vec![low, 0.5 * (low + high), high];
        levels.dedup();
        if out.len() * levels.len() > CANDIDATES {
            levels = vec![0.5 * (low + high)];
        }
        out = out
            .iter()
            .flat_map(|case| {
                levels.iter().map(move |level| {
                    let mut case = case.clone();
                    case.push(*level);
                    case
                })
            })
            .collect();
    }
    out
}

/// Places of all marks in units of their noise, and how they change with the unknowns of the deck.
type Seen = (DVector<f64>, DMatrix<f64>);

fn predict(
    subject: &Subject<'_>,
    fitted: &Fitted,
    candidates: &[Vec<f64>],
) -> Option<Vec<Option<Seen>>> {
    let problem = Problem {
        dataset: &fitted.deck.dataset,
        model: &fitted.deck.model,
        ..subject.problem.clone()
    };
    let programme = problem.programme;
    let cases: Vec<usize> = (0..programme.cases.len()).collect();
    let observations = Observations::new(problem.measurement, &fitted.deck.model, &cases);
    // What follows a load from case to case follows it to new ones.
    let follows = |factors: &[f64]| {
        (0..programme.loads.len()).find_map(|load| {
            let values = programme.cases.iter().map(|case| case.values[load]);
            let at = values
                .clone()
                .enumerate()
                .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
            let ratio = factors[at.0] / at.1;
            let same = values
                .zip(factors)
                .all(|(v, f)| (v * ratio - f).abs() <= 1e-9 * factors[at.0].abs());
            (ratio.is_finite() && same).then_some((load, ratio))
        })
    };
    let mut list: Vec<FitUnknown> = Vec::new();
    let mut per_case = Vec::new();
    for (unknown, x) in fitted.unknowns.list().iter().zip(&fitted.x) {
        let mut unknown = unknown.clone();
        if let Meaning::PerCase(slots) = &mut unknown.meaning {
            for (slot, factors) in slots {
                let (load, ratio) = follows(factors)?;
                *factors = candidates.iter().map(|c| c[load] * ratio).collect();
                per_case.push((*slot, factors.iter().map(|f| f * x).collect()));
            }
        }
        list.push(unknown);
    }
    let theta = fitted.thetas.last()?.clone();
    let unknowns = FitUnknowns::new(list);
    let count = unknowns.len();
    let directions: Vec<Direction> = unknowns.directions(&theta, &fitted.x[..count]);
    let mut predictor = fitted
        .deck
        .prepared
        .native(&problem, observations.observed.clone())
        .ok()?
        .with_cases(candidates.to_vec());
    let numbers = Numbers {
        theta,
        per_case,
        x: Vec::new(),
    };
    let prediction = predictor.predict(&numbers, Some(&directions));
    let seen = |prediction: CasePrediction| -> Seen {
        let marks = subject.problem.measurement.parts.iter();
        let rows = 3 * marks.clone().map(|part| part.marks.len()).sum::<usize>();
        let (mut x, mut J) = (DVector::zeros(rows), DMatrix::zeros(rows, count));
        let mut at = 0;
        for part in marks {
            let pose = &prediction.poses[part.part.0];
            let observed = &observations.observed.parts;
            let place = observed.iter().position(|p| *p == part.part);
            for mark in &part.marks {
                let point = pose.point(&mark.p) / subject.sigma;
                x.fixed_rows_mut::<3>(at).copy_from(&point);
                for (k, change) in prediction.by_unknown.iter().enumerate() {
                    let Some(place) = place else { continue };
                    let [x, y, z, a, b, c] = change.parts[place];
                    let arm = pose.R * mark.p;
                    let moved = Vec3::new(x, y, z) + Vec3::new(a, b, c).cross(&arm);
                    let mut column = J.column_mut(k);
                    let mut rows = column.fixed_rows_mut::<3>(at);
                    rows.copy_from(&(moved / subject.sigma));
                }
                at += 3;
            }
        }
        (x, J)
    };
    Some(prediction.into_iter().map(|p| p.map(seen)).collect())
}

fn mark_name(subject: &Subject<'_>, mut at: usize) -> String {
    for part in &subject.problem.measurement.parts {
        if at < part.marks.len() {
            return format!("{} {}", part.name, part.marks[at].label);
        }
        at -= part.marks.len();
    }
    "the wheel".to_string()
}
