//! Goals: the tests and load cases that each goal reads, and the misses of the values.

use crate::answers::Answers;
use crate::settings::LIMIT_SLACK;
use admire_kc::{Convention, KcRun, Probed, Reading, Sample, reading_change};
use admire_study::GoalScope;

/// Contribution of the misses of a goal to the cost.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum GoalKind {
    /// Half the mean square of the misses, in units of the tolerance, is added to the cost.
    Squares,
    /// Half the square of the largest miss, in units of the tolerance, is added to the cost.
    Minimax,
    /// Constraint: misses are not allowed, and nothing is added to the cost.
    Limit,
}

/// Quantity that a goal reads in a state of the deck.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Reads {
    /// A characteristic of the axle.
    Characteristic,
    /// Probe with this index among the probes of the tests or of the load cases.
    Probe(usize),
}

/// A goal with its names resolved. Characteristics are in the units of `curves.csv` and `gradients.csv`, in the axes of Adams/Car. Forces
/// and positions are in units of the deck, in its ground axes. Angles are in degrees.
#[derive(Clone, PartialEq, Debug)]
pub struct Goal {
    /// Name of the test, or `ride` for ride height; empty if the goal reads a load case.
    pub test: String,
    /// Label of the load case; `None` if the goal reads a test.
    pub case: Option<String>,
    /// Name of the quantity: a characteristic such as `toe_angle.left`, or a force, position or reading such as `BUSHING/3.FX`.
    pub of: String,
    /// Part of the characteristic: its curve, one value or its gradient.
    pub scope: GoalScope,
    /// Contribution of the misses to the cost.
    pub kind: GoalKind,
    /// Unit of the values, of the tolerance and of the misses.
    pub unit: String,
    /// Unit of the test's variable; empty at ride height and for a load case.
    pub at_unit: String,
    /// Tolerance: the unit in which misses are counted, and the largest miss at which the goal counts as met.
    pub tolerance: f64,
    /// Values that are compared.
    pub rows: Vec<Row>,
    /// True if the derivatives of the values are exact; false if they are finite differences.
    pub is_exact: bool,
    /// Factor of the goal in the cost: 1, except in the search for a Pareto front.
    pub weight: f64,
    pub(crate) reads: Reads,
}

/// Value that a goal compares: a linear combination of values in single states.
#[derive(Clone, PartialEq, Debug)]
pub struct Row {
    /// Value of the test's variable; 0 for a gradient, at ride height and for a load case.
    pub at: f64,
    /// Lower and upper limit of the wanted value. They are equal unless the goal is a limit.
    pub wanted: [f64; 2],
    /// States of the combination, each with its factor.
    pub(crate) parts: Vec<(StateIx, f64)>,
}

/// Reference to a state in [`Answers`].
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
    /// Returns the name of the goal: the test or load case, the characteristic, and the part of the characteristic unless it is a whole
    /// curve.
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

    /// Returns the largest miss at which the goal counts as met, in the unit of the goal.
    pub(crate) fn allowed(&self) -> f64 {
        match self.kind {
            GoalKind::Limit => LIMIT_SLACK * self.tolerance,
            GoalKind::Squares | GoalKind::Minimax => self.tolerance,
        }
    }

    /// Returns the value of a row; NaN if the quantity is undefined in a state.
    pub fn value(&self, row: &Row, found: &Answers) -> f64 {
        let one = |at: StateIx| match self.reads {
            Reads::Characteristic => value(reading(sample(found.run.as_ref()?, at)?, &self.of)?),
            Reads::Probe(k) => probed(found, at)?.values.get(k).copied(),
        };
        let each = row.parts.iter();
        each.map(|(at, factor)| factor * one(*at).unwrap_or(f64::NAN))
            .sum()
    }

    /// Returns the exact derivative of a row along direction `direction` of the answers; NaN if there is none.
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

    /// Returns the largest absolute miss over all values that deviate from `value` by at most `widening`.
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

/// Returns the reading of the characteristic with this path.
pub(crate) fn reading<'r>(sample: &'r Sample, path: &str) -> Option<&'r Reading> {
    let (entity, component) = path.split_once('.')?;
    let mut all = sample.readings.iter();
    all.find(|reading| reading.entity == entity && reading.component == component)
}
