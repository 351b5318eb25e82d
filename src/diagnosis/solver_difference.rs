//! What another solver makes of the same deck with the same numbers: before anything is said of a model, the two must agree.

use admire_syntax::text::Decimals;
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
        let told = |rms: f64| Decimals::of_error(sigma).finer().told(rms);
        if let Some(both) = self.residual_rms {
            let [own, other] = both.map(told);
            text += &format!(
                " Tolerances left out, the marks are missed by {own} by the built-in solver and by {other} by the other"
            );
            text += &match self.held_out_rms {
                Some(both) => {
                    let [own, other] = both.map(told);
                    format!(", by {own} and {other} in the cases held out.")
                }
                None => ".".to_string(),
            };
        }
        if let Some(rms) = self.refitted_rms {
            text += &format!(
                " The numbers below, the extended deck and the gain are fitted to the other solver, which then misses the marks by {}.",
                told(rms)
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
