//! What another solver makes of the same deck with the same numbers: before anything is said of a model, the two must agree.

use serde::Serialize;

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
}
