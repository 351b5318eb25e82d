use std::ops::ControlFlow;

use super::Unknown;
use super::free_motions::meet_marks_of_all;
use admire_session::backend::{
    Backend, BackendError, FreeMotions, LoadProgramme, Sweep, SweepRequest,
};
use admire_solver::model::Model;
use admire_study::settings::{IdentifySettings, RegressionSettings, Selection};
use admire_study::{CausePriors, Measurement, ToleranceSettings};
use admire_syntax::{Address, Dataset};

/// Inputs of an identification.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    /// Deck.
    pub dataset: &'a Dataset,
    /// Model of the deck.
    pub model: &'a Model,
    /// Loads and cases; the cases are those of the measurement, in the same order.
    pub programme: &'a LoadProgramme,
    /// Measured readings.
    pub measurement: &'a Measurement,
    /// Settings of `[identify]`.
    pub settings: &'a IdentifySettings,
    /// Settings of `[regression]`.
    pub regression: &'a RegressionSettings,
    /// Settings of `[tolerances]`.
    pub tolerances: &'a ToleranceSettings,
    /// `[priors]`.
    pub priors: &'a CausePriors,
    /// Method by which a diagnosis selects the causes.
    pub selection: Selection,
    /// Free (zero-stiffness) motions of the deck.
    pub free: &'a FreeMotions,
    /// Numbers to identify.
    pub unknowns: Vec<Unknown>,
}

impl Problem<'_> {
    /// Returns all addresses to set, with their numbers, for these values of the unknowns.
    pub fn theta(&self, values: &[f64]) -> Vec<(Address, f64)> {
        self.unknowns
            .iter()
            .zip(values)
            .flat_map(|(unknown, value)| unknown.assign(*value))
            .collect()
    }

    /// Solves all cases at these values of the unknowns. Along free motions, the parts are placed at the best fit of the measured marks.
    ///
    /// # Errors
    /// Returns [`BackendError`] if nothing could be solved.
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

    /// Returns the starting values of the unknowns.
    pub fn initial(&self) -> Vec<f64> {
        self.unknowns
            .iter()
            .map(|unknown| unknown.initial)
            .collect()
    }

    /// Returns the six stiffnesses of a bushing, with the unknowns replaced by their values.
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

    /// Returns the bushings with at least one unknown, in the order of the unknowns.
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

/// Callback after every iteration. Arguments: number of the iteration, current values, measure of the last change. `Break` stops the run and
/// keeps the values so far.
pub type Progress<'a> = dyn FnMut(usize, &[f64], f64) -> ControlFlow<()> + 'a;

/// Reason why an identification has no result.
#[derive(Clone, Debug, thiserror::Error)]
pub enum IdentifyError {
    /// The backend could not solve anything.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// No load case has both an equilibrium and readings.
    #[error("no load case has both an equilibrium and readings{}", .0.as_ref().map_or_else(String::new, |why| format!(": {why}")))]
    NoCases(Option<admire_session::backend::CaseFailure>),
    /// The study has no numbers to identify.
    #[error("the study names nothing to identify")]
    NoUnknowns,
    /// The study lacks an input of the method.
    #[error("method `{method}` needs {needs}")]
    NotPossible {
        /// Name of the method.
        method: &'static str,
        /// Description of the missing input.
        needs: &'static str,
    },
}
