//! Check of the motions of the marks (measured points on parts) against the table of loads. Before any fit, it reveals exchanged cases, and load
//! columns with a wrong sign or unit.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::check::Verdict;
use admire_identify::LoadedStudy;
use admire_study::Case;

/// Limit of the cosine between the measured and the predicted motion of the marks under a load. Below this limit, the marks move against the
/// model. Above its negative, they move with the model.
const AGAINST: f64 = -0.5;
/// Range of the ratio between measured and predicted motions that suggests confused units, such as newtons and kilonewtons.
const THOUSAND: (f64, f64) = (300.0, 3000.0);
/// Fraction of the unexplained motion that may remain after two cases are swapped. Up to this fraction, the two cases count as exchanged.
const EXCHANGED: f64 = 0.25;
/// Number of cases required in excess of the number of functions of the loads.
const SPARE: usize = 4;
/// Singular value, relative to the largest, below which a combination of functions of the loads counts as zero.
const RANK_TOLERANCE: f64 = 1e-6;

/// Returns findings that suggest a fault in the loads or marks. If `predicted` gives the prediction at the start values, the measured motions
/// are also compared with it.
pub(super) fn odd_loads(
    loaded: &LoadedStudy,
    predicted: Option<&[Case]>,
) -> Vec<(Verdict, String)> {
    let beside = predicted.and_then(|predicted| against(loaded, predicted));
    let mut out = beside.unwrap_or_default();
    out.extend(exchanged(loaded).map(|why| (Verdict::Impossible, why)));
    out
}

/// Finds the loads under which the marks move against the model, or about a thousand times more or less than the model.
fn against(loaded: &LoadedStudy, predicted: &[Case]) -> Option<Vec<(Verdict, String)>> {
    let to = &loaded.measurement;
    let cases: Vec<usize> = to.fitted_cases().collect();
    if cases.is_empty() {
        return None;
    }
    let loads = varying(&to.cases, &cases);
    let X = functions(&to.cases, &cases, &loads, false);
    let turn = X.svd(true, true);
    let slopes = |of: &[Case]| turn.solve(&coordinates(of, &cases)?, RANK_TOLERANCE).ok();
    let [read, model] = [slopes(&to.cases)?, slopes(predicted)?];
    if cases.len() < loads.len() + 1 + SPARE || turn.rank(RANK_TOLERANCE) <= loads.len() {
        return None;
    }
    let mut out = Vec::new();
    for (k, load) in loads.iter().enumerate() {
        let [read, model] = [read.row(k + 1), model.row(k + 1)];
        let (longer, size) = (model.norm() / read.norm(), model.norm() * read.norm());
        let together = read.dot(&model) / size;
        let name = &loaded.programme.loads[*load].name;
        if together < AGAINST {
            let why = format!(
                "under load {name}, the marks move against the model: check the sign of {name} in the table of loads"
            );
            out.push((Verdict::Doubtful, why));
        } else if together > -AGAINST {
            let times = longer.max(1.0 / longer);
            if times > THOUSAND.0 && times < THOUSAND.1 {
                let than = if longer > 1.0 { "less" } else { "more" };
                let why = format!(
                    "under load {name}, the marks move {times:.0} times {than} than the model: were newtons and kilonewtons confused?"
                );
                out.push((Verdict::Doubtful, why));
            }
        }
    }
    Some(out)
}

/// Finds two cases in which the marks fit the loads of the other case.
fn exchanged(loaded: &LoadedStudy) -> Option<String> {
    let to = &loaded.measurement.cases;
    let cases: Vec<usize> = (0..to.len()).collect();
    let loads = varying(to, &cases);
    let Y = coordinates(to, &cases)?;
    let enough = |products: bool| {
        let turn = functions(to, &cases, &loads, products).svd(true, false);
        let rank = turn.rank(RANK_TOLERANCE);
        (cases.len() >= rank + SPARE).then(|| turn.u.map(|u| u.columns(0, rank).into_owned()))?
    };
    let U = enough(true).or_else(|| enough(false))?;
    // `left` is M Y with M = I - U U', the part of the motion that no function of the loads explains.
    let left = &Y - &U * (U.transpose() * &Y);
    let before = left.norm_squared();
    let mut best: Option<(f64, usize, usize)> = None;
    for a in 0..cases.len() {
        for b in a + 1..cases.len() {
            // Let d be the difference of rows b and a of Y, and u the difference of the corresponding unit vectors. Swapping the two rows
            // gives the sum of squares of M (Y + u d').
            let d = Y.row(b) - Y.row(a);
            let along = d.dot(&(left.row(a) - left.row(b)));
            let own = (U.row(a) - U.row(b)).norm_squared();
            let after = before + 2.0 * along + (2.0 - own) * d.norm_squared();
            if best.is_none_or(|(least, ..)| after < least) {
                best = Some((after, a, b));
            }
        }
    }
    let (after, a, b) = best?;
    (after < EXCHANGED * before).then(|| {
        let [a, b] = [a, b].map(|case| &to[case].label);
        format!("the marks of case {a} fit the loads of case {b}, and those of case {b} the loads of case {a}: were the cases exchanged?")
    })
}

/// Returns the indices of the loads that differ between the given cases.
fn varying(all: &[Case], cases: &[usize]) -> Vec<usize> {
    let count = all.first().map_or(0, |case| case.loads.len());
    let is_constant = |load: &usize| {
        cases
            .iter()
            .all(|k| all[*k].loads[*load] == all[cases[0]].loads[*load])
    };
    (0..count).filter(|load| !is_constant(load)).collect()
}

/// Returns one row per case: 1, the loads relative to their largest magnitudes and, if `products` is set, the products of these relative
/// loads.
fn functions(all: &[Case], cases: &[usize], loads: &[usize], products: bool) -> DMatrix<f64> {
    let largest = |load: usize| {
        let values = cases.iter().map(|k| all[*k].loads[load].abs());
        values.fold(f64::MIN_POSITIVE, f64::max)
    };
    let scale: Vec<f64> = loads.iter().map(|load| largest(*load)).collect();
    let row = |case: &usize| {
        let own = loads.iter().zip(&scale);
        let own: Vec<f64> = own.map(|(k, scale)| all[*case].loads[*k] / scale).collect();
        let mut row = vec![1.0];
        row.extend(&own);
        if products {
            for (k, a) in own.iter().enumerate() {
                row.extend(own[k..].iter().map(|b| a * b));
            }
        }
        DVector::from_vec(row).transpose()
    };
    let rows: Vec<_> = cases.iter().map(row).collect();
    DMatrix::from_rows(&rows)
}

/// Returns one row per case: the coordinates of all marks that were read in every case. Returns `None` if there are no such marks.
fn coordinates(all: &[Case], cases: &[usize]) -> Option<DMatrix<f64>> {
    let mut columns: BTreeMap<(usize, usize, usize), Vec<f64>> = BTreeMap::new();
    for case in cases {
        for read in &all[*case].marks {
            for axis in 0..3 {
                let column = columns.entry((read.part, read.mark, axis)).or_default();
                column.push(read.x[axis]);
            }
        }
    }
    columns.retain(|_, column| column.len() == cases.len());
    let columns: Vec<DVector<f64>> = columns.into_values().map(DVector::from_vec).collect();
    (!columns.is_empty()).then(|| DMatrix::from_columns(&columns))
}
