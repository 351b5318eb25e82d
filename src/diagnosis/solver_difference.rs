//! Difference between two solvers on the same deck with the same parameters. The solvers must agree before the model is judged.

use crate::settings::NEGLIGIBLE_DIFFERENCE_SIGMA;
use serde::Serialize;

/// Difference between the solver of a study and the built-in solver.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct SolverDifference {
    /// Name of the study's solver: `command` or `replay`.
    pub solver: &'static str,
    /// Rms difference between the marks of the two solvers, per coordinate and in the deck's length unit. Without marks, the origins of the parts
    /// are compared.
    pub rms: f64,
    /// Largest distance between the two solvers' positions of one point, in the deck's length unit.
    pub most: f64,
    /// Label of the case with the largest distance; `None` if no case was solved by both solvers.
    pub case: Option<String>,
    /// Labels of the cases solved by only one of the solvers.
    pub unsolved: Vec<String>,
    /// Rms errors of the marks per coordinate, by the built-in solver and by the other solver, for the fitted model without tolerances. `None`
    /// without marks.
    pub residual_rms: Option<[f64; 2]>,
    /// Rms errors of the marks per coordinate over the held-out cases, by the built-in solver and by the other solver. `None` without held-out
    /// marks.
    pub held_out_rms: Option<[f64; 2]>,
    /// Rms error of the marks per coordinate by the other solver, for the extended model refitted to that solver, without tolerances. `None`
    /// without marks or without a refit.
    pub refitted_rms: Option<f64>,
}

impl SolverDifference {
    /// Returns true if both solvers solved the same cases, and if their difference is small against `sigma`, the noise of the marks per
    /// coordinate.
    pub fn is_negligible(&self, sigma: f64) -> bool {
        self.unsolved.is_empty() && self.rms <= NEGLIGIBLE_DIFFERENCE_SIGMA * sigma
    }
}
