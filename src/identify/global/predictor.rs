//! Predictions of a model for every load case, with their sensitivities to the unknowns.
//!
//! Independent of fits.

use std::ops::Range;

use nalgebra::DMatrix;

use super::free::SeenMark;
use super::unknown::{Component, Direction, Numbers};
use admire_solver::mechanics::Pose;
use admire_solver::model::PartIx;
use admire_solver::statics::Balance;
use admire_solver::system::{State, System};
use admire_study::{MarkReading, Measurement};

/// Prediction for one load case at equilibrium.
#[derive(Clone, PartialEq, Debug)]
pub struct CasePrediction {
    /// Pose of each part of the model, by [`PartIx`].
    pub poses: Vec<Pose>,
    /// One value per channel.
    pub channels: Vec<f64>,
    /// Changes per unknown; empty unless derivatives were requested.
    pub by_unknown: CaseChanges,
    /// Changes per free (zero-stiffness) motion.
    pub free: CaseChanges,
}

/// Change of the results of one load case per unit of an unknown.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct CaseChange<'a> {
    /// Translation of the part origin and rotation vector of each observed part, ground axes, in the order of [`Observed::parts`].
    pub parts: &'a [[f64; 6]],
    /// Change of each channel.
    pub channels: &'a [f64],
}

/// Changes of the results of one load case, stored contiguously.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct CaseChanges {
    count: usize,
    parts: Vec<[f64; 6]>,
    channels: Vec<f64>,
}

impl CaseChanges {
    /// Creates an empty list with room for `count` changes of `parts` parts and `channels` channels.
    pub(crate) fn with_capacity(count: usize, parts: usize, channels: usize) -> Self {
        Self {
            count: 0,
            parts: Vec::with_capacity(count * parts),
            channels: Vec::with_capacity(count * channels),
        }
    }

    /// Appends a change; all changes must have the same numbers of parts and channels.
    pub(crate) fn push(
        &mut self,
        parts: impl IntoIterator<Item = [f64; 6]>,
        channels: impl IntoIterator<Item = f64>,
    ) {
        self.count += 1;
        self.parts.extend(parts);
        self.channels.extend(channels);
    }

    /// Returns the number of changes.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Returns true if there are no changes.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the change of unknown `k`.
    pub fn get(&self, k: usize) -> CaseChange<'_> {
        let (parts, channels) = self.each();
        CaseChange {
            parts: &self.parts[k * parts..(k + 1) * parts],
            channels: &self.channels[k * channels..(k + 1) * channels],
        }
    }

    /// Iterates over the changes in the order of the unknowns.
    pub fn iter(&self) -> impl Iterator<Item = CaseChange<'_>> {
        (0..self.count).map(|k| self.get(k))
    }

    /// Returns a contiguous range of the changes.
    #[must_use]
    pub fn range(&self, range: Range<usize>) -> Self {
        let (parts, channels) = self.each();
        Self {
            count: range.len(),
            parts: self.parts[range.start * parts..range.end * parts].to_vec(),
            channels: self.channels[range.start * channels..range.end * channels].to_vec(),
        }
    }

    /// Returns the numbers of parts and channels of each change.
    fn each(&self) -> (usize, usize) {
        let count = self.count.max(1);
        (self.parts.len() / count, self.channels.len() / count)
    }
}

/// Parts and marks of a model that are compared with measurements.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Observed {
    /// Parts whose poses are observed.
    pub parts: Vec<PartIx>,
    /// Marks of these parts by load case. Along free (zero-stiffness) motions, a prediction is placed where it fits these marks best. Cases
    /// beyond the last entry have no marks.
    pub marks: Vec<Vec<SeenMark>>,
}

impl Observed {
    /// Returns the marked parts of a measurement with the readings of their marks.
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

    /// Returns the index of a part among the observed parts, and adds the part if it is missing.
    pub(super) fn place(&mut self, part: PartIx) -> usize {
        let known = self.parts.iter().position(|own| *own == part);
        known.unwrap_or_else(|| {
            self.parts.push(part);
            self.parts.len() - 1
        })
    }

    /// Converts changes of the system's unknowns at a state into changes of the observed parts and the channels; one column per change.
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

/// Predictions of all load cases in the order of application; `None` where a case has no equilibrium.
pub type Prediction = Vec<Option<CasePrediction>>;

/// A predictor of all load cases: the built-in solver with exact sensitivities, or any backend with differences.
pub trait Predictor {
    /// Returns the system whose numbers are changed.
    fn system(&self) -> &System;

    /// Solves every load case at these numbers, with sensitivities along `directions` if given.
    fn predict(&mut self, numbers: &Numbers, directions: Option<&[Direction]>) -> Prediction;

    /// Returns the load share of each spring at the last solutions; `None` if the backend cannot tell.
    ///
    /// The load share is the fraction of a force along the spring that the spring itself carries. A spring in series has share 1, and its
    /// deflection is proportional to 1/K. Where other elements impose the deflection, the share is nearly 0.
    fn shares(&mut self, _springs: &[Component]) -> Option<Vec<f64>> {
        None
    }

    /// Stores the last solutions of all cases.
    fn checkpoint(&mut self) {}

    /// Restores the stored solutions as the starting points of the next solves, because a trial may have reached another equilibrium.
    fn rollback(&mut self) {}

    /// Returns the number of sweeps over all load cases so far.
    fn sweeps(&self) -> usize;

    /// Returns the number of equilibria solved so far.
    fn solver_runs(&self) -> usize;

    /// Returns the largest force imbalance of a part over all solutions; `None` if the backend cannot tell.
    fn balance(&self) -> Option<&Balance>;
}
