//! Cases no fit saw: what a model says of them, and how much better it says it with the causes found.

use nalgebra::{DMatrix, DVector};

use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::fit::FittedModel;
use super::predictive::PredictiveDistribution;
use admire_identify::global::Row;
use admire_study::orientation::chi_square_p_value;

/// How held-out readings agree with a model.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct HeldOutTest {
    /// Rms of one mark coordinate, outliers left out.
    pub marks_rms: Option<f64>,
    /// Rms of camber and steer of the wheel, degrees.
    pub wheel_deg_rms: Option<[f64; 2]>,
    /// Chi-square with the prediction's own covariance.
    pub chi_square: f64,
    /// Readings in it.
    pub dof: usize,
    /// Its p-value.
    pub p_value: f64,
}

/// A model that has not seen the cases held out.
#[derive(Clone, Debug)]
pub struct Blind {
    /// Prediction minus reading of all rows.
    pub misfit: DVector<f64>,
    /// Covariance of its unknowns.
    covariance: DMatrix<f64>,
}

impl Blind {
    /// A fit without the cases held out, in the linear model of all. What acts on single rows alone is as it was.
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

    /// Tests the held-out rows; `None` where there are none.
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

    /// Rms of one mark coordinate held out, outliers left out.
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

/// Rows of the cases and curves held out.
pub(super) fn unseen(subject: &DiagnosisProblem<'_>) -> Vec<usize> {
    (0..subject.rows.len())
        .filter(|k| subject.is_held_out_row(&subject.rows[*k]))
        .collect()
}

/// Those of them by which predictions are compared; outliers left out.
pub(super) fn compared(subject: &DiagnosisProblem<'_>) -> Vec<usize> {
    let marks_alone = subject.compared().0 == "mark";
    let is_compared = |k: &usize| {
        let of_a_mark = matches!(subject.rows[*k], Row::Mark { .. });
        subject.precision[*k] > 0.0 && (of_a_mark || !marks_alone)
    };
    unseen(subject).into_iter().filter(is_compared).collect()
}

/// How large a change of all rows is: rms of marks and channels in units of their noise, and of wheel angles in degrees.
/// Where there are neither marks nor channels all readings of the wheel stand for them.
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
