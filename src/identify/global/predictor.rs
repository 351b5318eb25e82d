//! What a model says of every load case, and how that changes with the unknowns.
//!
//! Knows neither measurements nor fits.

use super::unknown::{Component, Direction, Numbers};
use crate::mechanics::Pose;
use crate::model::PartIx;
use crate::statics::Balance;
use crate::system::System;

/// One load case at equilibrium.
#[derive(Clone, PartialEq, Debug)]
pub struct CasePrediction {
    /// Pose of each part of the model, by [`PartIx`].
    pub poses: Vec<Pose>,
    /// One value per channel.
    pub channels: Vec<f64>,
    /// One per unknown; empty unless asked for.
    pub by_unknown: Vec<CaseChange>,
}

/// How one load case changes per unit of an unknown.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct CaseChange {
    /// (translation of the part origin, rotation vector) of each observed part, ground axes; in the order of
    /// [`Observed::parts`].
    pub parts: Vec<[f64; 6]>,
    /// Change of each channel.
    pub channels: Vec<f64>,
}

/// What of a model is compared with measurements.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Observed {
    /// Parts whose pose matters.
    pub parts: Vec<PartIx>,
}

/// Every load case in the order of application; `None` where there is no equilibrium.
pub(crate) type Prediction = Vec<Option<CasePrediction>>;

/// Predicts all load cases: the built-in solver with exact sensitivities, or any backend with differences.
pub trait Predictor {
    /// The system whose numbers are changed.
    fn system(&self) -> &System;

    /// Solves every load case at these numbers; with changes along `directions` when given.
    fn predict(&mut self, numbers: &Numbers, directions: Option<&[Direction]>) -> Prediction;

    /// For each spring which share of a force along it it carries itself, at the last answers: 1 in series, where its deflection
    /// goes with 1/K, nearly 0 where other elements impose its deflection. `None` if the backend does not know.
    fn shares(&mut self, _springs: &[Component]) -> Option<Vec<f64>> {
        None
    }

    /// Remembers the last answers of all cases.
    fn keep(&mut self) {}

    /// Lets the next solve of each case start from what was remembered last: a trial may have led to another equilibrium.
    fn go_back(&mut self) {}

    /// How often all load cases were solved so far.
    fn sweeps(&self) -> usize;

    /// How many equilibria were solved so far.
    fn solver_runs(&self) -> usize;

    /// What was left of the forces on a part at worst, in all of them; `None` if the backend does not know.
    fn balance(&self) -> Option<&Balance>;
}
