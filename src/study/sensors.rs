//! Scalar sensors of a study as functions of its deck.

use super::kc_curves::with_helpers;
use super::measurement::Measurement;
use admire_solver::mechanics::Pose;
use admire_solver::model::{Model, Request};
use admire_solver::system::{NoValue, Parameters, Scratch, State, System};
use admire_syntax::diagnostic::Diagnostic;

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
    /// Place of the first.
    pub first: usize,
    /// How many there are.
    pub count: usize,
}

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
        let mut here = system.evaluate(theta, state, scratch)?;
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
        let Ok(mut here) = system.evaluate(theta, &state, scratch) else {
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
}
