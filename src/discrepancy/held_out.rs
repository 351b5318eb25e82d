//! What a model says of load cases no fit saw.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::extended::Fitted;
use super::subject::Subject;
use crate::identify::global::Row;
use crate::rig::orientation::chi_square_p_value;

/// How the held-out readings agree with a fit.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct HeldOutTest {
    /// Rms of one mark coordinate.
    pub marks_rms: Option<f64>,
    /// Chi-square with the prediction's own covariance, `J Sigma J^T + I`.
    pub chi_square: f64,
    /// Its p-value.
    pub p_value: f64,
}

/// Tests the held-out rows; `None` where there are none. Rows that a found fault of the measurement touches are left out.
pub fn held_out_test(subject: &Subject<'_>, fitted: &Fitted) -> Option<HeldOutTest> {
    let touched = touched_rows(fitted);
    let rows: Vec<usize> = (0..subject.rows.len())
        .filter(|k| subject.is_held_out(subject.rows[*k].case()) && !touched.contains(k))
        .collect();
    if rows.is_empty() {
        return None;
    }
    let evaluation = &fitted.minimum.evaluation;
    let r = DVector::from_iterator(rows.len(), rows.iter().map(|k| evaluation.residual[*k]));
    let J = evaluation.jacobian.select_rows(&rows);
    let S = &J * fitted.covariance() * J.transpose() + DMatrix::identity(rows.len(), rows.len());
    let chi_square = r.dot(&Cholesky::new(S)?.solve(&r));
    Some(HeldOutTest {
        marks_rms: marks_rms(subject, fitted, &rows),
        chi_square,
        p_value: chi_square_p_value(chi_square, rows.len()),
    })
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
        .map(|k| fitted.minimum.evaluation.residual[*k].powi(2))
        .collect();
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    (!squares.is_empty()).then(|| mean.sqrt() * subject.sigma)
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
    let (a, b) = (
        &with.minimum.evaluation.residual,
        &without.minimum.evaluation.residual,
    );
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
