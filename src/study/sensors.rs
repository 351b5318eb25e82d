//! Channels (scalar sensors) of a study, evaluated as functions of its deck.

use super::kc_curves::with_helpers;
use super::measurement::Measurement;
use admire_solver::mechanics::Pose;
use admire_solver::model::{Model, Request};
use admire_solver::system::{NoValue, Parameters, Scratch, State, System};
use admire_syntax::diagnostic::Diagnostic;

/// Returns the model with one additional REQUEST per channel. The function of each channel is thus compiled and differentiated like a function
/// of the deck. Channels for the functions in `further`, which are not measured, follow the channels of the measurement.
///
/// # Errors
/// Fails if the function of a channel cannot be parsed.
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

/// Range of the channels among the requests of the model.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Channels {
    /// Index of the first request that is a channel.
    pub first: usize,
    /// Number of channels.
    pub count: usize,
}

impl Channels {
    /// Evaluates the channels at a state of the solver.
    ///
    /// # Errors
    /// Returns [`NoValue`] if the function of a channel is undefined at this state.
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
        let mut here = system.evaluate(theta, state, scratch)?;
        for k in 0..self.count {
            let read = here.read_function(self.first + k, 1)?;
            values.push(read.map_or(f64::NAN, |(value, _)| value));
        }
        Ok(values)
    }

    /// Evaluates the channels at part poses from an external solver. The value of a channel is `None` if its function is undefined there. It is
    /// also `None` if the function depends on more than poses and parameters, such as on a joint reaction or a VARIABLE.
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
        let Ok(mut here) = system.evaluate(theta, &state, scratch) else {
            return values;
        };
        let places = system.equations_start();
        for (k, value) in values.iter_mut().enumerate() {
            if let Ok(Some((found, gradient))) = here.read_function(self.first + k, 1) {
                let of_places = gradient.iter().all(|(unknown, _)| *unknown < places);
                *value = of_places.then_some(found);
            }
        }
        values
    }
}
