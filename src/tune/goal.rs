//! Goals: the tests and load cases that each goal reads, and the misses of its values.

use crate::answers::Answers;
use crate::settings::LIMIT_SLACK;
use admire_kc::{Convention, KcRun, Probed, Reading, Sample, reading_change};
use admire_study::GoalScope;

/// Contribution of the misses of a goal to the cost.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum GoalKind {
    /// Half the mean square of the misses, in units of the tolerance, is part of the cost.
    Squares,
    /// Half the square of the largest miss is part of the cost.
    Minimax,
    /// No miss is allowed.
    Limit,
}

/// What a goal reads in a state of the deck.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Reads {
    /// A characteristic of the axle.
    Characteristic,
    /// The probe with this index among those of the tests or of the load cases.
    Probe(usize),
}

/// A goal with its names resolved. Characteristics are in the units of `curves.csv` and `gradients.csv`, in the axes of Adams/Car. Forces and
/// places are in units of the deck and in ground axes of the deck, angles in degrees.
#[derive(Clone, PartialEq, Debug)]
pub struct Goal {
    /// Name of the test; `ride` for ride height. Empty for a goal of a load case.
    pub test: String,
    /// Label of the load case; `None` for a goal of a test.
    pub case: Option<String>,
    /// Characteristic such as `toe_angle.left`, or a force, place or reading such as `BUSHING/3.FX`.
    pub of: String,
    /// Part of the characteristic.
    pub scope: GoalScope,
    /// Contribution of the misses to the cost.
    pub kind: GoalKind,
    /// Unit of values, tolerance and misses.
    pub unit: String,
    /// Unit of the test's variable; empty at ride height and in a load case.
    pub at_unit: String,
    /// Unit of the misses, and largest miss with which the goal is met.
    pub tolerance: f64,
    /// Values that are compared.
    pub rows: Vec<Row>,
    /// True if the derivatives of the values are exact; otherwise they are differences.
    pub is_exact: bool,
    /// Factor of the goal in the cost; 1 unless a Pareto front is sought.
    pub weight: f64,
    pub(crate) reads: Reads,
}

/// One value that a goal compares: a linear combination of the values in single states.
#[derive(Clone, PartialEq, Debug)]
pub struct Row {
    /// Value of the test's variable; 0 for a gradient, at ride height and in a load case.
    pub at: f64,
    /// Smallest and largest wanted value. They are equal unless the goal is a limit.
    pub wanted: [f64; 2],
    /// States of the combination, each with its factor.
    pub(crate) parts: Vec<(StateIx, f64)>,
}

/// A state among the answers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum StateIx {
    /// Ride height.
    Ride,
    /// Sample of a test: index of the test in the run, and index of the sample in the test.
    Sample(usize, usize),
    /// Index of a load case.
    Case(usize),
}

impl Goal {
    /// Returns the name: the test or load case, the characteristic, and the part of the characteristic unless it is a whole curve.
    pub fn name(&self) -> String {
        let part = match (self.scope, &self.case) {
            (GoalScope::Curve, _) | (_, Some(_)) => "",
            (GoalScope::Value, None) => ", value",
            (GoalScope::Gradient, None) => ", gradient",
        };
        let limits = if self.kind == GoalKind::Limit {
            ", limits"
        } else {
            ""
        };
        let place = match &self.case {
            Some(label) => format!("case {label}"),
            None => self.test.clone(),
        };
        format!("{place} {}{part}{limits}", self.of)
    }

    /// Returns the miss up to which the goal is met, in its unit.
    pub(crate) fn allowed(&self) -> f64 {
        match self.kind {
            GoalKind::Limit => LIMIT_SLACK * self.tolerance,
            GoalKind::Squares | GoalKind::Minimax => self.tolerance,
        }
    }

    /// Returns the value of a row; NaN if the goal is not defined there.
    pub fn value(&self, row: &Row, found: &Answers) -> f64 {
        let one = |at: StateIx| match self.reads {
            Reads::Characteristic => value(reading(sample(found.run.as_ref()?, at)?, &self.of)?),
            Reads::Probe(k) => probed(found, at)?.values.get(k).copied(),
        };
        let each = row.parts.iter();
        each.map(|(at, factor)| factor * one(*at).unwrap_or(f64::NAN))
            .sum()
    }

    /// Returns the exact derivative of a row along a direction of the answers; NaN if there is none.
    pub(crate) fn change(&self, row: &Row, found: &Answers, direction: usize) -> f64 {
        let one = |at: StateIx| match self.reads {
            Reads::Characteristic => {
                let sample = sample(found.run.as_ref()?, at)?;
                let sense = reading(sample, &self.of)?.sense;
                let change = reading_change(sample, direction, &self.of)?;
                Some(Convention::AdamsCar.factor(sense) * change)
            }
            Reads::Probe(k) => {
                let changes = probed(found, at)?.changes.get(direction)?;
                changes.get(k).copied()
            }
        };
        let each = row.parts.iter();
        each.map(|(at, factor)| factor * one(*at).unwrap_or(f64::NAN))
            .sum()
    }
}

impl Row {
    /// Returns the miss of a value: positive above the wanted range, negative below it, and zero within it.
    pub fn miss(&self, value: f64) -> f64 {
        let [least, most] = self.wanted;
        if value < least {
            value - least
        } else if value > most {
            value - most
        } else if value.is_nan() {
            f64::NAN
        } else {
            0.0
        }
    }

    /// Returns the largest size of a miss over all values that are off by `widening` at most, to both sides.
    pub(crate) fn reach(&self, value: f64, widening: f64) -> f64 {
        let [least, most] = self.wanted;
        let beyond = (value + widening - most).max(least - (value - widening));
        if beyond.is_nan() {
            f64::NAN
        } else {
            beyond.max(0.0)
        }
    }
}

fn value(reading: &Reading) -> Option<f64> {
    Some(reading.value_in(Convention::AdamsCar))
}

fn sample(run: &KcRun, at: StateIx) -> Option<&Sample> {
    match at {
        StateIx::Ride => Some(&run.ride),
        StateIx::Sample(test, sample) => run.tests.get(test)?.samples.get(sample),
        StateIx::Case(_) => None,
    }
}

fn probed(found: &Answers, at: StateIx) -> Option<&Probed> {
    match at {
        StateIx::Case(k) => Some(&found.cases.get(k)?.probed),
        _ => Some(&sample(found.run.as_ref()?, at)?.probed),
    }
}

/// Returns the reading of a characteristic, given as its path.
pub(crate) fn reading<'r>(sample: &'r Sample, path: &str) -> Option<&'r Reading> {
    let (entity, component) = path.split_once('.')?;
    let mut all = sample.readings.iter();
    all.find(|reading| reading.entity == entity && reading.component == component)
}
