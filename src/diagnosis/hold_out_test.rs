//! Prediction of held-out cases by a fitted model, and the test of that prediction.

use nalgebra::{DMatrix, DVector};

use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::fit::FittedModel;
use super::predictive::PredictiveDistribution;
use admire_identify::global::Row;
use admire_study::orientation::chi_square_p_value;

/// Agreement of the held-out readings with a model's prediction.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct HeldOutTest {
    /// Rms error of the marks without outliers, per coordinate and in the deck's length unit. `None` without held-out marks.
    pub marks_rms: Option<f64>,
    /// Rms errors of the wheel's camber and steer angles, in degrees. `None` without held-out wheel readings.
    pub wheel_deg_rms: Option<[f64; 2]>,
    /// Chi-square of the held-out readings under the prediction and its covariance.
    pub chi_square: f64,
    /// Number of readings in the test, which is its number of degrees of freedom.
    pub dof: usize,
    /// P-value of the chi-square.
    pub p_value: f64,
}

/// Linear model of a fit, conditioned on the cases that are not held out.
#[derive(Clone, Debug)]
pub struct HoldOutPrediction {
    /// Prediction minus reading of all rows, in units of the declared noise.
    pub misfit: DVector<f64>,
    /// Posterior covariance of the unknowns.
    covariance: DMatrix<f64>,
}

impl HoldOutPrediction {
    /// Conditions the linear model of a fit on the cases that are not held out. Parameters that act on held-out rows alone return to their
    /// priors. Returns `None` if nothing is held out.
    pub fn new(subject: &DiagnosisProblem<'_>, fitted: &FittedModel) -> Option<Self> {
        if !subject.holds_out() {
            return None;
        }
        let (misfit, posterior) = fitted.relinearised_on(&subject.whitening(Data::Fitted))?;
        Some(Self {
            misfit,
            covariance: posterior.covariance,
        })
    }

    /// Tests the prediction of the held-out rows. Returns `None` if no held-out row is in use.
    pub fn test(
        &self,
        subject: &DiagnosisProblem<'_>,
        fitted: &FittedModel,
    ) -> Option<HeldOutTest> {
        let rows = unseen(subject);
        let (chi_square, dof) = self.chi_square(subject, fitted, &rows)?;
        Some(HeldOutTest {
            marks_rms: self.marks_rms(subject),
            wheel_deg_rms: self.wheel_rms(subject, &rows),
            chi_square,
            dof,
            p_value: chi_square_p_value(chi_square, dof),
        })
    }

    fn chi_square(
        &self,
        subject: &DiagnosisProblem<'_>,
        fitted: &FittedModel,
        rows: &[usize],
    ) -> Option<(f64, usize)> {
        let mut only = vec![false; subject.rows.len()];
        for row in rows {
            only[*row] = true;
        }
        let whitening = subject.whitening(Data::All);
        let weights = whitening.weights(&fitted.sizes.ln);
        let turned: Vec<usize> = (0..only.len())
            .filter(|k| only[*k] && weights[*k] > 0.0)
            .collect();
        if turned.is_empty() {
            return None;
        }
        let r = whitening.apply_vector(&self.misfit).component_mul(&weights);
        let mut J = whitening.apply(&fitted.jacobian);
        for (mut row, weight) in J.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        let (r, J) = (r.select_rows(&turned), J.select_rows(&turned));
        let foreseen = PredictiveDistribution::new(J, &self.covariance);
        Some((foreseen.chi_square(&r)?, turned.len()))
    }

    /// Returns the rms error of the held-out marks without outliers, per coordinate and in the deck's length unit.
    pub fn marks_rms(&self, subject: &DiagnosisProblem<'_>) -> Option<f64> {
        let rows = unseen(subject).into_iter();
        let marks = rows.filter(|k| {
            matches!(subject.rows[*k], Row::Mark { .. }) && subject.precision[*k] > 0.0
        });
        let squares: Vec<f64> = marks.map(|k| self.misfit[k].powi(2)).collect();
        let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
        (!squares.is_empty()).then(|| mean.sqrt() * subject.sigma)
    }

    fn wheel_rms(&self, subject: &DiagnosisProblem<'_>, rows: &[usize]) -> Option<[f64; 2]> {
        let sigma = subject.problem.measurement.wheel.as_ref()?.sigma_angle_deg;
        let rms = |component: usize| {
            let of = |k: &&usize| matches!(subject.rows[**k], Row::Wheel { component: c, .. } if c == component);
            let squares: Vec<f64> = rows
                .iter()
                .filter(of)
                .map(|k| (self.misfit[*k] * sigma).powi(2))
                .collect();
            (!squares.is_empty())
                .then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
        };
        Some([rms(3)?, rms(4)?])
    }
}

/// Returns the indices of the residual rows of held-out cases and curves.
pub(super) fn unseen(subject: &DiagnosisProblem<'_>) -> Vec<usize> {
    (0..subject.rows.len())
        .filter(|k| subject.is_held_out_row(&subject.rows[*k]))
        .collect()
}

/// Returns the indices of the held-out rows on which predictions are compared, without outliers.
pub(super) fn compared(subject: &DiagnosisProblem<'_>) -> Vec<usize> {
    let marks_alone = subject.compared().0 == "mark";
    let is_compared = |k: &usize| {
        let of_a_mark = matches!(subject.rows[*k], Row::Mark { .. });
        subject.precision[*k] > 0.0 && (of_a_mark || !marks_alone)
    };
    unseen(subject).into_iter().filter(is_compared).collect()
}

/// Returns two rms sizes of a change of all rows. The first covers marks and channels, in units of their noise. The second covers the wheel
/// angles, in degrees. Without marks and channels, the first covers all wheel readings, in units of their noise.
pub(super) fn moved(subject: &DiagnosisProblem<'_>, rows: &DVector<f64>) -> (f64, f64) {
    let (mut marks, mut angles, mut wheel) = ((0.0, 0), (0.0, 0), (0.0, 0));
    let sigmas = subject.problem.measurement.wheel.as_ref();
    let angle = sigmas.map_or(0.0, |w| w.sigma_angle_deg);
    let unit = subject.sigma / subject.mark_sigma();
    let add = |(sum, count): &mut (f64, i32), change: f64| {
        *sum += change * change;
        *count += 1;
    };
    for (k, row) in subject.rows.iter().enumerate() {
        let change = rows[k];
        match row {
            Row::Mark { .. } => add(&mut marks, change * unit),
            Row::Channel { .. } => add(&mut marks, change),
            Row::Wheel { component, .. } => {
                add(&mut wheel, change);
                if *component >= 3 {
                    add(&mut angles, change * angle);
                }
            }
        }
    }
    let rms = |(sum, count): (f64, i32)| (sum / f64::from(count.max(1))).sqrt();
    let readings = if marks.1 > 0 { marks } else { wheel };
    (rms(readings), rms(angles))
}
