use std::ops::ControlFlow;

use super::Unknown;
use super::free_motions::meet_marks_of_all;
use super::unknowns::assigned;
use admire_session::backend::{
    Backend, BackendError, FreeMotions, LoadProgramme, Sweep, SweepRequest,
};
use admire_solver::model::Model;
use admire_study::settings::{IdentifySettings, RegressionSettings};
use admire_study::{CausePriors, Measurement, ToleranceSettings};
use admire_syntax::{Address, Dataset};

/// Inputs of an identification.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    /// Deck of the study.
    pub dataset: &'a Dataset,
    /// Model of the deck.
    pub model: &'a Model,
    /// Loads and load cases. The load cases are the cases of `measurement`, in the same order.
    pub programme: &'a LoadProgramme,
    /// Readings of the measurement.
    pub measurement: &'a Measurement,
    /// Settings of section `[identify]` of `study.toml`.
    pub settings: &'a IdentifySettings,
    /// Settings of section `[regression]` of `study.toml`.
    pub regression: &'a RegressionSettings,
    /// Settings of section `[tolerances]` of `study.toml`.
    pub tolerances: &'a ToleranceSettings,
    /// Settings of section `[priors]` of `study.toml`.
    pub priors: &'a CausePriors,
    /// Free (zero-stiffness) motions of the deck.
    pub free: &'a FreeMotions,
    /// Parameters of the deck to identify.
    pub unknowns: Vec<Unknown>,
}

impl Problem<'_> {
    /// Returns the deck addresses to set, each with its value, for the given values of the unknowns.
    pub fn theta(&self, values: &[f64]) -> Vec<(Address, f64)> {
        assigned(&self.unknowns, values.iter().copied())
    }

    /// Solves all load cases at the given values of the unknowns. Along free (zero-stiffness) motions, the parts are then moved to the best fit
    /// of their measured marks.
    ///
    /// # Errors
    /// Returns [`BackendError`] if the sweep fails as a whole.
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

    /// Returns true if any unknown is a change or a factor of numbers of the deck, and not a number itself.
    pub(crate) fn changes_numbers(&self) -> bool {
        let mut unknowns = self.unknowns.iter();
        unknowns.any(|unknown| !unknown.changed_numbers().is_empty())
    }

    /// Returns true if an unknown represents this change of the deck. The change is then not added as a manufacturing error.
    pub fn seeks_change(&self, change: &[(Address, f64)]) -> bool {
        self.unknowns.iter().any(|unknown| unknown.includes(change))
    }

    /// Returns the starting values of the unknowns.
    pub fn initial(&self) -> Vec<f64> {
        self.unknowns
            .iter()
            .map(|unknown| unknown.initial)
            .collect()
    }

    /// Returns the six stiffnesses of a bushing. Identified stiffnesses have the given values; the others have the values of the deck.
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

    /// Returns the indices of the bushings with at least one unknown, in the order of the unknowns.
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

/// Callback that runs after every iteration of a method. Its arguments are the number of iterations so far, the current values of the unknowns,
/// and the size of their last change. If it returns `Break`, the run stops and keeps these values.
pub type Progress<'a> = dyn FnMut(usize, &[f64], f64) -> ControlFlow<()> + 'a;

/// Reason why an identification has no result.
#[derive(Clone, Debug, thiserror::Error)]
pub enum IdentifyError {
    /// The backend failed as a whole.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// No load case has both an equilibrium and readings.
    #[error("no load case has both an equilibrium and readings{}", .0.as_ref().map_or_else(String::new, |why| format!(": {why}")))]
    NoCases(Option<admire_session::backend::CaseFailure>),
    /// The study selects no parameters to identify.
    #[error("the study names no parameters to identify")]
    NoUnknowns,
    /// The study lacks an input that the method needs.
    #[error("method `{method}` needs {needs}")]
    NotPossible {
        /// Name of the method.
        method: &'static str,
        /// Description of the missing input.
        needs: &'static str,
    },
}
