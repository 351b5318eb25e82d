//! What a model says of every load case, and how that changes with the unknowns.
//!
//! Knows no fits.

use std::ops::Range;

use nalgebra::DMatrix;

use super::free::SeenMark;
use super::unknown::{Component, Direction, Numbers};
use admire_solver::mechanics::Pose;
use admire_solver::model::PartIx;
use admire_solver::statics::Balance;
use admire_solver::system::{State, System};
use admire_study::{MarkReading, Measurement};

/// One load case at equilibrium.
#[derive(Clone, PartialEq, Debug)]
pub struct CasePrediction {
    /// Pose of each part of the model, by [`PartIx`].
    pub poses: Vec<Pose>,
    /// One value per channel.
    pub channels: Vec<f64>,
    /// One per unknown; empty unless asked for.
    pub by_unknown: CaseChanges,
    /// One per motion that nothing resists.
    pub free: CaseChanges,
}

/// How one load case changes per unit of an unknown.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct CaseChange<'a> {
    /// (translation of the part origin, rotation vector) of each observed part, ground axes; in the order of
    /// [`Observed::parts`].
    pub parts: &'a [[f64; 6]],
    /// Change of each channel.
    pub channels: &'a [f64],
}

/// Changes of one load case, one after the other.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct CaseChanges {
    count: usize,
    parts: Vec<[f64; 6]>,
    channels: Vec<f64>,
}

impl CaseChanges {
    /// None yet, with room for so many of so many parts and channels.
    pub(crate) fn with_capacity(count: usize, parts: usize, channels: usize) -> Self {
        Self {
            count: 0,
            parts: Vec::with_capacity(count * parts),
            channels: Vec::with_capacity(count * channels),
        }
    }

    /// Adds one; each has as many parts and channels as the first.
    pub(crate) fn push(
        &mut self,
        parts: impl IntoIterator<Item = [f64; 6]>,
        channels: impl IntoIterator<Item = f64>,
    ) {
        self.count += 1;
        self.parts.extend(parts);
        self.channels.extend(channels);
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The one of unknown `k`.
    pub fn get(&self, k: usize) -> CaseChange<'_> {
        let (parts, channels) = self.each();
        CaseChange {
            parts: &self.parts[k * parts..(k + 1) * parts],
            channels: &self.channels[k * channels..(k + 1) * channels],
        }
    }

    /// In the order of the unknowns.
    pub fn iter(&self) -> impl Iterator<Item = CaseChange<'_>> {
        (0..self.count).map(|k| self.get(k))
    }

    /// Some that follow one another.
    #[must_use]
    pub fn range(&self, range: Range<usize>) -> Self {
        let (parts, channels) = self.each();
        Self {
            count: range.len(),
            parts: self.parts[range.start * parts..range.end * parts].to_vec(),
            channels: self.channels[range.start * channels..range.end * channels].to_vec(),
        }
    }

    /// Numbers of parts and channels of each.
    fn each(&self) -> (usize, usize) {
        let count = self.count.max(1);
        (self.parts.len() / count, self.channels.len() / count)
    }
}

/// What of a model is compared with measurements.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Observed {
    /// Parts whose pose matters.
    pub parts: Vec<PartIx>,
    /// Marks of those parts by load case: predictions are taken where these are met best along motions that nothing resists. Cases beyond the
    /// last have none.
    pub marks: Vec<Vec<SeenMark>>,
}

impl Observed {
    /// The marked parts of a measurement, and where their marks were read.
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

    /// Where a part is among those observed, which it is from now on.
    pub(super) fn place(&mut self, part: PartIx) -> usize {
        let known = self.parts.iter().position(|own| *own == part);
        known.unwrap_or_else(|| {
            self.parts.push(part);
            self.parts.len() - 1
        })
    }

    /// What is observed of changes of the system's unknowns at a state and of the channels, columns of both.
    pub fn changes(
        &self,
        (system, state): (&System, &State),
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

/// Every load case in the order of application; `None` where there is no equilibrium.
pub type Prediction = Vec<Option<CasePrediction>>;

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
    fn checkpoint(&mut self) {}

    /// Lets the next solve of each case start from what was remembered last: a trial may have led to another equilibrium.
    fn rollback(&mut self) {}

    /// How often all load cases were solved so far.
    fn sweeps(&self) -> usize;

    /// How many equilibria were solved so far.
    fn solver_runs(&self) -> usize;

    /// What was left of the forces on a part at worst, in all of them; `None` if the backend does not know.
    fn balance(&self) -> Option<&Balance>;
}
