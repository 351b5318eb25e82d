//! What another solver makes of the same deck with the same numbers: before anything is said of a model, the two must agree.

use serde::Serialize;

use super::diagnose::Outcome;
use crate::backend::{Backend, BackendError, NativeBackend};
use crate::mechanics::Vec3;

/// A difference of the solvers below this part of the noise of a mark is none.
const NONE: f64 = 0.1;

/// How far the solver of a study and the built-in one are apart.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct SolverDifference {
    /// `command` or `replay`.
    pub solver: &'static str,
    /// Rms of the difference of one coordinate, in the deck's length unit: of marks, or of the origins of parts where there are none.
    pub rms: f64,
    /// The largest difference of a place.
    pub most: f64,
    /// The case in which that is; `None` where no case was solved by both.
    pub case: Option<String>,
    /// Cases that one of the two did not solve.
    pub unsolved: Vec<String>,
    /// Rms of one mark coordinate, reading minus prediction, of the fitted model without tolerances: by the built-in solver and by the
    /// other. `None` without marks.
    pub residual_rms: Option<[f64; 2]>,
    /// The same over the cases held out.
    pub held_out_rms: Option<[f64; 2]>,
    /// Rms of one mark coordinate, reading minus prediction of the other solver, of the extended model without tolerances, fitted to that
    /// solver. `None` without marks, or where it was not fitted to it.
    pub refitted_rms: Option<f64>,
}

impl SolverDifference {
    /// True if it is small against the noise of a mark.
    pub fn is_negligible(&self, sigma: f64) -> bool {
        self.unsolved.is_empty() && self.rms <= NONE * sigma
    }

    /// As a person would say it.
    pub fn sentence(&self, sigma: f64, unit: &str) -> String {
        let mut text = format!(
            "With the fitted stiffnesses the solver of the study ({}) and the built-in one differ by {:.2e} {unit} rms per coordinate",
            self.solver, self.rms
        );
        if let Some(case) = &self.case {
            text += &format!(", at most by {:.2e} in case {case}", self.most);
        }
        text += if self.is_negligible(sigma) {
            ", which is small against the noise."
        } else {
            ": what is found below may be a difference of the solvers."
        };
        if let Some([own, other]) = self.residual_rms {
            text += &format!(
                " Tolerances left out, the marks are missed by {own:.4} by the built-in solver and by {other:.4} by the other"
            );
            text += &match self.held_out_rms {
                Some([own, other]) => {
                    format!(", by {own:.4} and {other:.4} in the cases held out.")
                }
                None => ".".to_string(),
            };
        }
        if let Some(rms) = self.refitted_rms {
            text += &format!(
                " The numbers below, the extended deck and the gain are fitted to the other solver, which then misses the marks by {rms:.4}."
            );
        }
        if !self.unsolved.is_empty() {
            text += &format!(
                " Only one of them solved case {}.",
                self.unsolved.join(", ")
            );
        }
        text
    }
}

impl Outcome<'_> {
    /// Solves the deck with the stiffnesses of the fit without causes by another solver and by the built-in one, and takes note of the
    /// difference.
    ///
    /// # Errors
    /// [`BackendError`] when one of them could not solve anything.
    pub fn compare(&mut self, other: &mut dyn Backend) -> Result<(), BackendError> {
        let problem = &self.subject.problem;
        let values: Vec<f64> = (0..problem.unknowns.len())
            .map(|k| self.baseline.stiffness(k).0)
            .collect();
        let sweeps = [
            problem.sweep(&mut NativeBackend::new(), &values)?,
            problem.sweep(other, &values)?,
        ];
        let measurement = problem.measurement;
        let mut unsolved = Vec::new();
        let mut most: (f64, Option<String>) = (0.0, None);
        let (mut squares, mut count) = (0.0, 0.0);
        // Sums of squares of reading minus prediction by each solver, and coordinates: of all cases, of those held out.
        let mut residuals = [[0.0; 3]; 2];
        for (k, case) in measurement.cases.iter().enumerate() {
            let [Some(own), Some(foreign)] = sweeps.each_ref().map(|sweep| sweep.equilibrium(k))
            else {
                let solved = sweeps.iter().any(|sweep| sweep.equilibrium(k).is_some());
                if solved {
                    unsolved.push(case.label.clone());
                }
                continue;
            };
            let mut places: Vec<[Vec3; 2]> = Vec::new();
            for (reading, read) in case.marks.iter().enumerate() {
                let part = &measurement.parts[read.part];
                let place = part.marks[read.mark].p;
                let both = [own, foreign].map(|at| at.poses[part.part.0].point(&place));
                let outliers = self.subject.noise.outliers.iter();
                if !outliers
                    .clone()
                    .any(|o| (o.case, o.reading) == (k, reading))
                {
                    for (held, sums) in residuals.iter_mut().enumerate() {
                        if held == 0 || self.subject.is_held_out(k) {
                            for (sum, at) in sums.iter_mut().zip(&both) {
                                *sum += (read.x - at).norm_squared();
                            }
                            sums[2] += 3.0;
                        }
                    }
                }
                places.push(both);
            }
            if places.is_empty() {
                let pairs = own.poses.iter().zip(&foreign.poses);
                places.extend(pairs.map(|(a, b)| [a.p, b.p]));
            }
            for [a, b] in places {
                let apart = (a - b).norm();
                squares += apart * apart;
                count += 3.0;
                if apart >= most.0 {
                    most = (apart, Some(case.label.clone()));
                }
            }
        }
        let rms = |sums: [f64; 3]| {
            (sums[2] > 0.0).then(|| [(sums[0] / sums[2]).sqrt(), (sums[1] / sums[2]).sqrt()])
        };
        self.diagnosis.solver = Some(SolverDifference {
            solver: other.name(),
            rms: (squares / f64::max(count, 1.0)).sqrt(),
            most: most.0,
            case: most.1,
            unsolved,
            residual_rms: rms(residuals[0]),
            held_out_rms: rms(residuals[1]),
            refitted_rms: None,
        });
        Ok(())
    }
}
