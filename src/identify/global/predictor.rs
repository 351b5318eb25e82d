//! Predictions of a model for all load cases, with their sensitivities to the unknowns.
//!
//! This module is independent of fits.

use std::ops::Range;

use nalgebra::DMatrix;

use super::free::SeenMark;
use super::unknown::{Component, Direction, Numbers};
use admire_solver::mechanics::Pose;
use admire_solver::model::PartIx;
use admire_solver::statics::Balance;
use admire_solver::system::{State, System};
use admire_study::{MarkReading, Measurement};

/// Equilibrium of the model in one load case, with the predicted channel values and the sensitivities.
#[derive(Clone, PartialEq, Debug)]
pub struct CasePrediction {
    /// Pose of each part of the model at equilibrium, indexed by [`PartIx`].
    pub poses: Vec<Pose>,
    /// Predicted value of each channel.
    pub channels: Vec<f64>,
    /// Derivatives of the results with respect to each unknown; empty unless derivatives were requested.
    pub by_unknown: CaseChanges,
    /// Derivatives of the results with respect to each free (zero-stiffness) motion.
    pub free: CaseChanges,
}

/// Derivative of the results of one load case with respect to an unknown or a free motion.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct CaseChange<'a> {
    /// Derivative of the pose of each observed part, in the order of [`Observed::parts`]: translation of the part origin, then rotation vector,
    /// both in ground axes.
    pub parts: &'a [[f64; 6]],
    /// Derivative of each channel value.
    pub channels: &'a [f64],
}

/// Derivatives of the results of one load case with respect to several unknowns, stored contiguously.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct CaseChanges {
    count: usize,
    parts: Vec<[f64; 6]>,
    channels: Vec<f64>,
}

impl CaseChanges {
    /// Creates an empty list with room for `count` derivatives of `parts` parts and `channels` channels.
    pub(crate) fn with_capacity(count: usize, parts: usize, channels: usize) -> Self {
        Self {
            count: 0,
            parts: Vec::with_capacity(count * parts),
            channels: Vec::with_capacity(count * channels),
        }
    }

    /// Appends the derivative with respect to a further unknown. All entries must have the same number of parts and of channels.
    pub(crate) fn push(
        &mut self,
        parts: impl IntoIterator<Item = [f64; 6]>,
        channels: impl IntoIterator<Item = f64>,
    ) {
        self.count += 1;
        self.parts.extend(parts);
        self.channels.extend(channels);
    }

    /// Returns the number of unknowns for which derivatives are stored.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Returns true if no derivatives are stored.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the derivative with respect to unknown `k`.
    pub fn get(&self, k: usize) -> CaseChange<'_> {
        let (parts, channels) = self.each();
        CaseChange {
            parts: &self.parts[k * parts..(k + 1) * parts],
            channels: &self.channels[k * channels..(k + 1) * channels],
        }
    }

    /// Iterates over the derivatives in the order of the unknowns.
    pub fn iter(&self) -> impl Iterator<Item = CaseChange<'_>> {
        (0..self.count).map(|k| self.get(k))
    }

    /// Returns the derivatives with respect to a contiguous range of the unknowns.
    #[must_use]
    pub fn range(&self, range: Range<usize>) -> Self {
        let (parts, channels) = self.each();
        Self {
            count: range.len(),
            parts: self.parts[range.start * parts..range.end * parts].to_vec(),
            channels: self.channels[range.start * channels..range.end * channels].to_vec(),
        }
    }

    /// Returns the number of parts and the number of channels in each derivative.
    fn each(&self) -> (usize, usize) {
        let count = self.count.max(1);
        (self.parts.len() / count, self.channels.len() / count)
    }
}

/// Parts and marks (measured points) of a model that are compared with measurements.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Observed {
    /// Parts whose poses are compared, directly or through their marks.
    pub parts: Vec<PartIx>,
    /// Marks of these parts with their measured positions, by load case. Along free (zero-stiffness) motions, a prediction is placed where it
    /// fits these marks best. Load cases beyond the last entry have no marks.
    pub marks: Vec<Vec<SeenMark>>,
}

impl Observed {
    /// Returns the parts of a measurement that carry marks, with the readings of the marks.
    pub fn of(measurement: &Measurement) -> Self {
        let mut new = Self::default();
        let place: Vec<usize> = measurement
            .parts
            .iter()
            .map(|own| new.place(own.part))
            .collect();
        let seen = |read: &MarkReading| SeenMark {
            part: place[read.part],
            local: measurement.parts[read.part].marks[read.mark].p,
            x: read.x,
        };
        let cases = measurement.cases.iter();
        new.marks = cases
            .map(|case| case.marks.iter().map(seen).collect())
            .collect();
        new
    }

    /// Returns the index of a part in the list of observed parts. A part that is missing is added.
    pub(super) fn place(&mut self, part: PartIx) -> usize {
        let known = self.parts.iter().position(|own| *own == part);
        known.unwrap_or_else(|| {
            self.parts.push(part);
            self.parts.len() - 1
        })
    }

    /// Converts derivatives of the solver's unknowns at a state to derivatives of the observed parts. Each column of `responses` is one
    /// derivative; the matching column of `channels` is added unchanged.
    pub fn changes(
        &self,
        system: &System,
        state: &State,
        responses: &DMatrix<f64>,
        channels: &DMatrix<f64>,
    ) -> CaseChanges {
        let (parts, sensors) = (self.parts.len(), channels.nrows());
        let mut out = CaseChanges::with_capacity(responses.ncols(), parts, sensors);
        for (dx, channels) in responses.column_iter().zip(channels.column_iter()) {
            let share = |part: &PartIx| system.pose_change(state, *part, dx.as_slice());
            out.push(self.parts.iter().map(share), channels.iter().copied());
        }
        out
    }
}

/// Predictions of all load cases in the order of application. The entry of a case without an equilibrium is `None`.
pub type Prediction = Vec<Option<CasePrediction>>;

/// Predictor of the results of all load cases: the built-in solver with exact sensitivities, or any backend with finite differences.
pub trait Predictor {
    /// Returns the compiled system whose parameters are changed.
    fn system(&self) -> &System;

    /// Solves every load case for these parameter values, with sensitivities along `directions` if given.
    fn predict(&mut self, numbers: &Numbers, directions: Option<&[Direction]>) -> Prediction;

    /// Returns the load share of each spring at the last solutions; `None` if the backend does not provide it.
    ///
    /// The load share is the fraction of a force along the spring that the spring itself carries. A spring in series has share 1, and its
    /// deflection is proportional to 1/K. If other elements impose the deflection, the share is nearly 0.
    fn shares(&mut self, _springs: &[Component]) -> Option<Vec<f64>> {
        None
    }

    /// Stores the last solutions of all load cases.
    fn checkpoint(&mut self) {}

    /// Restores the solutions of the last checkpoint as starting points of the next prediction. A rejected trial step may have reached a
    /// different equilibrium.
    fn rollback(&mut self) {}

    /// Returns the number of sweeps over all load cases so far.
    fn sweeps(&self) -> usize;

    /// Returns the number of equilibria solved so far.
    fn solver_runs(&self) -> usize;

    /// Returns the largest force imbalance of a part over all solutions; `None` if the backend does not report it.
    fn balance(&self) -> Option<&Balance>;
}
