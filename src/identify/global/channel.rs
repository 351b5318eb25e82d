//! Scalar sensors of a study as functions of its deck.

use crate::diagnostic::Diagnostic;
use crate::mechanics::Pose;
use crate::model::{Model, Request};
use crate::rig::{Measurement, with_helpers};
use crate::system::{NoValue, Parameters, Scratch, State, System};

use super::unknown::Direction;

/// The model with one more REQUEST per channel, which compiles and differentiates its function like any of the deck's own; after
/// the channels of the measurement come `further` functions that nobody measured.
///
/// # Errors
/// A channel's function that does not follow the grammar of expressions.
pub fn with_channels(
    model: &Model,
    measurement: &Measurement,
    further: &[String],
) -> Result<(Model, Channels), Diagnostic> {
    let mut model = model.clone();
    let helpers = measurement.channels.iter().flat_map(|c| &c.helpers);
    with_helpers(&mut model, helpers);
    let first = model.requests.len();
    let measured = measurement
        .channels
        .iter()
        .map(|channel| (&channel.name, &channel.function));
    let unnamed = String::new();
    let further = further.iter().map(|function| (&unnamed, function));
    for (name, function) in measured.chain(further) {
        model.requests.push(Request::of_function(name, function)?);
    }
    let channels = Channels {
        first,
        count: model.requests.len() - first,
    };
    Ok((model, channels))
}

/// Where the channels stand among the requests of the model.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Channels {
    first: usize,
    count: usize,
}

/// Step of the difference that finds how a channel depends on theta where nothing moves: relative to one unit of the unknown.
const STEP: f64 = 1e-5;

impl Channels {
    /// Values in a configuration.
    ///
    /// # Errors
    /// [`NoValue`] if a function is undefined there.
    pub fn values(
        self,
        system: &System,
        theta: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<Vec<f64>, NoValue> {
        let mut values = Vec::with_capacity(self.count);
        if self.count == 0 {
            return Ok(values);
        }
        let mut here = system.look(theta, state, scratch)?;
        for k in 0..self.count {
            let read = here.read_function((self.first + k, 1))?;
            values.push(read.map_or(f64::NAN, |(value, _)| value));
        }
        Ok(values)
    }

    /// Values where another solver puts all parts. `None` of a channel that does not follow from places and numbers alone, such as
    /// a reaction or a VARIABLE, and of one without a value there.
    pub fn at(
        self,
        system: &System,
        theta: &Parameters,
        poses: &[Pose],
        scratch: &mut Scratch,
    ) -> Vec<Option<f64>> {
        let mut state = system.state();
        let mut values = vec![None; self.count];
        if self.count == 0 || state.poses.len() != poses.len() {
            return values;
        }
        state.poses.copy_from_slice(poses);
        let Ok(mut here) = system.look(theta, &state, scratch) else {
            return values;
        };
        let places = system.equations_start();
        for (k, value) in values.iter_mut().enumerate() {
            if let Ok(Some((found, gradient))) = here.read_function((self.first + k, 1)) {
                let of_places = gradient.iter().all(|(unknown, _)| *unknown < places);
                *value = of_places.then_some(found);
            }
        }
        values
    }

    /// Changes along each direction, given how the system's unknowns respond to it.
    ///
    /// # Errors
    /// [`NoValue`] if a function is undefined there.
    pub fn changes(
        self,
        system: &System,
        (theta, case): (&Parameters, usize),
        state: &State,
        scratch: &mut Scratch,
        (directions, responses): (&[Direction], &[Vec<f64>]),
    ) -> Result<Vec<Vec<f64>>, NoValue> {
        let mut out = vec![Vec::with_capacity(self.count); directions.len()];
        if self.count == 0 {
            return Ok(out);
        }
        let mut here = system.look(theta, state, scratch)?;
        for k in 0..self.count {
            let Some((_, gradient)) = here.read_function((self.first + k, 1))? else {
                continue;
            };
            for (changes, response) in out.iter_mut().zip(responses) {
                changes.push(
                    gradient
                        .iter()
                        .map(|(unknown, by)| by * response[*unknown])
                        .sum(),
                );
            }
        }
        // A spring's force depends on its stiffness, a place on a part on its marker, even where nothing moves.
        let mut near = theta.clone();
        for (changes, direction) in out.iter_mut().zip(directions) {
            if !self.read(system, direction, case) {
                continue;
            }
            let mut at = |step: f64| {
                near.clone_from(theta);
                for (slot, factor) in direction.in_case(case) {
                    near.set(slot, near.get(slot) + step * factor);
                }
                for (marker, axis) in &direction.turns {
                    near.turn(*marker, axis, step);
                }
                self.values(system, &near, state, scratch)
            };
            let (up, down) = (at(STEP)?, at(-STEP)?);
            for (change, (up, down)) in changes.iter_mut().zip(up.iter().zip(&down)) {
                *change += (up - down) / (2.0 * STEP);
            }
        }
        Ok(out)
    }

    /// True if a channel may change along a direction while nothing moves.
    fn read(self, system: &System, direction: &Direction, case: usize) -> bool {
        let mut numbers = direction.in_case(case).filter(|(_, weight)| *weight != 0.0);
        let mut functions = (0..self.count).map(|k| (self.first + k, 1));
        numbers.any(|(slot, _)| functions.clone().any(|k| system.request_reads(k, slot)))
            || functions.any(|k| {
                let mut turns = direction.turns.iter();
                turns.any(|(marker, _)| system.request_reads_marker(k, *marker))
            })
    }
}
