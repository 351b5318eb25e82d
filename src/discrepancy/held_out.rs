//! What a model says of load cases no fit saw.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::extended::Fitted;
use super::subject::{Data, Subject};
use crate::identify::global::Row;
use crate::rig::orientation::chi_square_p_value;

/// How the held-out readings agree with a fit.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct HeldOutTest {
    /// Rms of one mark coordinate.
    pub marks_rms: Option<f64>,
    /// Rms of camber and steer of the wheel, degrees.
    pub wheel_deg_rms: Option<[f64; 2]>,
    /// Chi-square with the prediction's own covariance, `J Sigma J^T + I`.
    pub chi_square: f64,
    /// Readings in it.
    pub dof: usize,
    /// Its p-value.
    pub p_value: f64,
}

/// Tests the held-out rows; `None` where there are none. Rows that a found fault of the measurement touches are left out.
pub fn held_out_test(subject: &Subject<'_>, fitted: &Fitted) -> Option<HeldOutTest> {
    let rows = unseen_rows(subject, fitted);
    let chi_square = chi_square(subject, fitted, &rows)?;
    Some(HeldOutTest {
        marks_rms: marks_rms(subject, fitted, &rows),
        wheel_deg_rms: wheel_rms(subject, fitted, &rows),
        chi_square,
        dof: rows.len(),
        p_value: chi_square_p_value(chi_square, rows.len()),
    })
}

/// The held-out case that agrees least with the prediction, and the p-value of its readings, corrected for the number of cases.
pub fn worst_case(subject: &Subject<'_>, fitted: &Fitted) -> Option<(usize, f64)> {
    let mut by_case = std::collections::BTreeMap::<usize, Vec<usize>>::new();
    for k in unseen_rows(subject, fitted) {
        by_case.entry(subject.rows[k].case()).or_default().push(k);
    }
    let count = by_case.len() as f64;
    by_case
        .into_iter()
        .filter_map(|(case, rows)| {
            let chi_square = chi_square(subject, fitted, &rows)?;
            let p = chi_square_p_value(chi_square, rows.len()) * count;
            Some((case, p.min(1.0)))
        })
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Rows of held-out cases that no found fault of the measurement touches.
fn unseen_rows(subject: &Subject<'_>, fitted: &Fitted) -> Vec<usize> {
    let touched = touched_rows(fitted);
    (0..subject.rows.len())
        .filter(|k| subject.is_held_out(subject.rows[*k].case()) && !touched.contains(k))
        .collect()
}

/// Chi-square of rows a fit has not seen, with the covariance of their prediction; `None` of no rows.
fn chi_square(subject: &Subject<'_>, fitted: &Fitted, rows: &[usize]) -> Option<f64> {
    if rows.is_empty() {
        return None;
    }
    let evaluation = &fitted.minimum.evaluation;
    let r = DVector::from_iterator(rows.len(), rows.iter().map(|k| fitted.misfit[*k]));
    let J = evaluation.jacobian.select_rows(rows);
    let mut S =
        &J * fitted.covariance() * J.transpose() + DMatrix::identity(rows.len(), rows.len());
    if let Some(background) = subject.background(Data::All) {
        S += background.covariance(rows);
    }
    Some(r.dot(&Cholesky::new(S)?.solve(&r)))
}

/// Rows on which a chosen hypothesis acts directly.
fn touched_rows(fitted: &Fitted) -> Vec<usize> {
    fitted
        .chosen
        .iter()
        .filter(|h| h.cause.of_the_measurement())
        .flat_map(|h| &h.numbers)
        .flat_map(|number| match &number.column {
            super::hypothesis::Column::Rows(rows) => rows.iter().map(|(k, _)| *k).collect(),
            _ => Vec::new(),
        })
        .collect()
}

fn marks_rms(subject: &Subject<'_>, fitted: &Fitted, rows: &[usize]) -> Option<f64> {
    let squares: Vec<f64> = rows
        .iter()
        .filter(|k| matches!(subject.rows[**k], Row::Mark { .. }))
        .map(|k| fitted.misfit[*k].powi(2))
        .collect();
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    (!squares.is_empty()).then(|| mean.sqrt() * subject.sigma)
}

fn wheel_rms(subject: &Subject<'_>, fitted: &Fitted, rows: &[usize]) -> Option<[f64; 2]> {
    let sigma = subject.problem.measurement.wheel.as_ref()?.sigma_angle_deg;
    let rms = |component: usize| {
        let squares: Vec<f64> = rows
            .iter()
            .filter(|k| {
                matches!(subject.rows[**k], Row::Wheel { component: of, .. } if of == component)
            })
            .map(|k| (fitted.misfit[*k] * sigma).powi(2))
            .collect();
        (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
    };
    Some([rms(3)?, rms(4)?])
}

/// By how much the rms of marks held out falls from one fit to another, with its standard error: the cases are left out one after the
/// other (jackknife), because the readings of one case share their errors.
pub fn marks_gain(subject: &Subject<'_>, before: &Fitted, after: &Fitted) -> Option<(f64, f64)> {
    let touched = touched_rows(after);
    let mut by_case = std::collections::BTreeMap::new();
    for (k, row) in subject.rows.iter().enumerate() {
        let Row::Mark { case, .. } = *row else {
            continue;
        };
        if !subject.is_held_out(case) || touched.contains(&k) {
            continue;
        }
        let sums = by_case.entry(case).or_insert([0.0; 3]);
        sums[0] += before.misfit[k].powi(2);
        sums[1] += after.misfit[k].powi(2);
        sums[2] += 1.0;
    }
    let gain = |without: Option<usize>| {
        let mut sums = [0.0; 3];
        for (_, own) in by_case.iter().filter(|(case, _)| Some(**case) != without) {
            for (sum, own) in sums.iter_mut().zip(own) {
                *sum += own;
            }
        }
        ((sums[0] / sums[2]).sqrt() - (sums[1] / sums[2]).sqrt()) * subject.sigma
    };
    let n = by_case.len() as f64;
    if by_case.is_empty() {
        return None;
    }
    let left: Vec<f64> = by_case.keys().map(|case| gain(Some(*case))).collect();
    let mean = left.iter().sum::<f64>() / n;
    let spread: f64 = left.iter().map(|g| (g - mean).powi(2)).sum();
    let error = if n > 1.0 {
        (spread * (n - 1.0) / n).sqrt()
    } else {
        f64::NAN
    };
    Some((gain(None), error))
}

/// What a hypothesis moves: rms of marks in units of their noise, and of wheel angles in degrees.
pub fn moved(subject: &Subject<'_>, with: &Fitted, without: &Fitted, all: bool) -> (f64, f64) {
    let (mut marks, mut angles) = ((0.0, 0), (0.0, 0));
    let angle = subject
        .problem
        .measurement
        .wheel
        .as_ref()
        .map_or(0.0, |w| w.sigma_angle_deg);
    let (a, b) = (&with.misfit, &without.misfit);
    for (k, row) in subject.rows.iter().enumerate() {
        if !all && subject.holds_out() && !subject.is_held_out(row.case()) {
            continue;
        }
        let change = a[k] - b[k];
        let (sum, scale) = match row {
            Row::Mark { .. } | Row::Channel { .. } => (&mut marks, 1.0),
            Row::Wheel { component: 3.., .. } => (&mut angles, angle),
            Row::Wheel { .. } => continue,
        };
        sum.0 += (change * scale).powi(2);
        sum.1 += 1;
    }
    let rms = |(sum, count): (f64, i32)| (sum / f64::from(count.max(1))).sqrt();
    (rms(marks), rms(angles))
}
