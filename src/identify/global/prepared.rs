//! The deck of a study, compiled for a fit.

use super::native::NativePredictor;
use super::predictor::Observed;
use crate::{IdentifyError, Problem};
use admire_session::backend::{BackendError, Loads, compile};
use admire_solver::model::Model;
use admire_solver::system::{Scratch, System};
use admire_study::{Channels, with_channels};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// The deck of a study with its channels (scalar sensors), compiled.
#[derive(Debug)]
pub struct Prepared {
    /// Model of the deck with one REQUEST per channel.
    pub model: Model,
    /// Range of the channels among the requests of the model.
    pub channels: Channels,
    /// Compiled model.
    pub system: System,
}

impl Prepared {
    /// Compiles the deck of a study for the built-in solver.
    ///
    /// # Errors
    /// Fails if the built-in solver cannot solve the deck, or if the function of a channel cannot be parsed.
    pub fn new(problem: &Problem<'_>) -> Result<Self, IdentifyError> {
        Self::with(problem, &[])
    }

    /// Compiles the deck of a study with additional channels for the functions in `further`. They follow the channels of the measurement.
    ///
    /// # Errors
    /// See [`Self::new`].
    pub fn with(problem: &Problem<'_>, further: &[String]) -> Result<Self, IdentifyError> {
        let (model, channels) = with_channels(problem.model, problem.measurement, further)
            .map_err(|diagnostic| BackendError::NotSolvable(vec![diagnostic]))?;
        let system = compile(&model)?;
        Ok(Self {
            model,
            channels,
            system,
        })
    }

    /// Compiles the deck of a study for the evaluation of channels when an external solver computes the equilibria. Elements that the built-in
    /// solver does not support are ignored. Channels are evaluated from the poses of the parts, which every solver returns.
    ///
    /// # Errors
    /// Fails if the function of a channel cannot be parsed, or does not depend on the poses alone.
    pub fn external(problem: &Problem<'_>) -> Result<Self, IdentifyError> {
        let (model, channels) = with_channels(problem.model, problem.measurement, &[])
            .map_err(|diagnostic| BackendError::NotSolvable(vec![diagnostic]))?;
        let system = System::compile(&model).value;
        let poses = &system.state().poses;
        let design = channels.at(
            &system,
            &system.parameters(),
            poses,
            &mut Scratch::new(&system),
        );
        let named = problem.measurement.channels.iter().zip(design);
        let refused: Vec<Diagnostic> = named
            .filter(|(_, value)| value.is_none())
            .map(|(channel, _)| {
                let message = format!(
                    "the results of another solver do not determine the channel `{}`: {} is not a function of the positions of the parts",
                    channel.name, channel.function
                );
                Diagnostic::error(Code::BadSetting, message)
                    .help("leave the channel out, or set solver.backend = \"native\"")
            })
            .collect();
        if !refused.is_empty() {
            return Err(BackendError::NotSolvable(refused).into());
        }
        Ok(Self {
            model,
            channels,
            system,
        })
    }

    /// Creates a predictor for the study that uses the built-in solver.
    ///
    /// # Errors
    /// Fails if the solver cannot change a parameter that a load drives.
    pub fn native(
        &self,
        problem: &Problem<'_>,
        observed: Observed,
    ) -> Result<NativePredictor<'_>, IdentifyError> {
        let loads = Loads::of(&self.system, problem.programme)?;
        let predictor = NativePredictor::new(&self.system, loads, observed, self.channels);
        Ok(predictor.with_free_motions(problem.free))
    }
}
