//! Comparison of the study's solver with the built-in solver at the same parameter values.

use super::diagnose::Outcome;
use super::solver_difference::SolverDifference;
use admire_session::backend::{Backend, BackendError, NativeBackend};
use admire_solver::mechanics::Vec3;

impl Outcome<'_> {
    /// Solves the deck with the solver `other` and with the built-in solver, both at the stiffnesses of the fit without causes. Records the
    /// difference of the two solvers in the diagnosis.
    ///
    /// # Errors
    /// [`BackendError`] if one of the two solvers could not solve any case.
    pub fn compare(&mut self, other: &mut dyn Backend) -> Result<(), BackendError> {
        let problem = &self.subject.problem;
        let unknowns = problem.unknowns.iter().enumerate();
        let values: Vec<f64> = unknowns
            .map(|(k, unknown)| self.baseline.identified(k, unknown).0)
            .collect();
        let sweeps = [
            problem.sweep(&mut NativeBackend::new(), &values)?,
            problem.sweep(other, &values)?,
        ];
        let measurement = problem.measurement;
        let mut unsolved = Vec::new();
        let mut most: (f64, Option<String>) = (0.0, None);
        let (mut squares, mut count) = (0.0, 0.0);
        // Sum of squares of reading minus prediction by the built-in solver, the same sum for the other solver, and the number of
        // coordinates. The first row is for all cases, the second for the held-out cases.
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
                if !self.subject.noise.is_wrong(k, reading, read) {
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
