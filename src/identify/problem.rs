use std::ops::ControlFlow;

use super::Unknown;
use super::free_motions::meet_marks_of_all;
use admire_session::backend::{
    Backend, BackendError, FreeMotions, LoadProgramme, Sweep, SweepRequest,
};
use admire_solver::model::Model;
use admire_study::settings::{IdentifySettings, RegressionSettings};
use admire_study::{CausePriors, Measurement, ToleranceSettings};
use admire_syntax::{Address, Dataset};

/// All an identification works with.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    /// The deck.
    pub dataset: &'a Dataset,
    /// The deck, lowered.
    pub model: &'a Model,
    /// Loads and cases; the cases are those of the measurement, in the same order.
    pub programme: &'a LoadProgramme,
    /// What was measured.
    pub measurement: &'a Measurement,
    /// `[identify]`.
    pub settings: &'a IdentifySettings,
    /// `[regression]`.
    pub regression: &'a RegressionSettings,
    /// `[tolerances]`.
    pub tolerances: &'a ToleranceSettings,
    /// `[priors]`.
    pub priors: &'a CausePriors,
    /// Motions of the deck that nothing resists.
    pub free: &'a FreeMotions,
    /// What is sought.
    pub unknowns: Vec<Unknown>,
}

impl Problem<'_> {
    /// Every address to set for these values of the unknowns.
    pub(crate) fn theta(&self, values: &[f64]) -> Vec<(Address, f64)> {
        self.unknowns
            .iter()
            .zip(values)
            .flat_map(|(unknown, value)| unknown.assign(*value))
            .collect()
    }

    /// Solves all cases with these values of the unknowns. Along motions that nothing resists the parts are where the marks were read.
    ///
    /// # Errors
    /// [`BackendError`] when nothing could be solved.
    pub fn sweep(&self, backend: &mut dyn Backend, values: &[f64]) -> Result<Sweep, BackendError> {
        let mut sweep = backend.sweep(&SweepRequest {
            dataset: self.dataset,
            model: self.model,
            theta: &self.theta(values),
            programme: self.programme,
        })?;
        meet_marks_of_all(self.free, &mut sweep, self.measurement);
        Ok(sweep)
    }

    /// Where the unknowns start.
    pub fn initial(&self) -> Vec<f64> {
        self.unknowns
            .iter()
            .map(|unknown| unknown.initial)
            .collect()
    }

    /// The six stiffnesses of a bushing, unknowns replaced by their values.
    pub fn stiffnesses(&self, bushing: usize, values: &[f64]) -> [f64; 6] {
        let law = &self.model.bushings[bushing];
        let mut k = [0.0; 6];
        k[..3].copy_from_slice(&law.k);
        k[3..].copy_from_slice(&law.kt);
        for (unknown, value) in self.unknowns.iter().zip(values) {
            for (of, axis) in unknown.axes() {
                if of == bushing {
                    k[axis] = *value;
                }
            }
        }
        k
    }

    /// The bushings that hold an unknown, in the order of the unknowns.
    pub fn bushings(&self) -> Vec<usize> {
        let mut found = Vec::new();
        for (bushing, _) in self.unknowns.iter().flat_map(Unknown::axes) {
            if !found.contains(&bushing) {
                found.push(bushing);
            }
        }
        found
    }
}

/// Told after every iteration: its number, the values so far, and a measure of what still moves. Breaking stops the run; what
/// was found so far is kept.
pub type Progress<'a> = dyn FnMut(usize, &[f64], f64) -> ControlFlow<()> + 'a;

/// Why there is no result at all.
#[derive(Clone, Debug, thiserror::Error)]
pub enum IdentifyError {
    /// The backend could not solve anything.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// No case the solver can reach has readings.
    #[error("no load case has both an equilibrium and readings{}", .0.as_ref().map_or_else(String::new, |why| format!(": {why}")))]
    NoCases(Option<admire_session::backend::CaseFailure>),
    /// Nothing to identify.
    #[error("the study names nothing to identify")]
    NoUnknowns,
    /// The method needs what the study does not have.
    #[error("method `{method}` needs {needs}")]
    NotPossible {
        /// The method.
        method: &'static str,
        /// What it needs.
        needs: &'static str,
    },
}
