//! A study's deck compiled with what a fit needs of it.

use super::native::NativePredictor;
use super::predictor::Observed;
use crate::{IdentifyError, Problem};
use admire_session::backend::{BackendError, Loads, compile};
use admire_solver::model::Model;
use admire_solver::system::{Scratch, System};
use admire_study::{Channels, with_channels};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// A study's deck with its channels, compiled.
#[derive(Debug)]
pub struct Prepared {
    /// The deck's model with one REQUEST per channel.
    pub model: Model,
    /// Where they stand.
    pub channels: Channels,
    /// The compiled model.
    pub system: System,
}

impl Prepared {
    /// Compiles the deck of a study.
    ///
    /// # Errors
    /// What the built-in solver cannot solve, or a channel whose function cannot be read.
    pub fn new(problem: &Problem<'_>) -> Result<Self, IdentifyError> {
        Self::with(problem, &[])
    }

    /// The same with channels for `further` functions after those of the measurement.
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

    /// The same for a deck that another program solves: what the built-in solver cannot solve is left to it. Channels are taken from the
    /// places of the parts, which every solver tells.
    ///
    /// # Errors
    /// A channel whose function cannot be read, or needs more than these places.
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
                    "the results of another solver do not tell the channel `{}`: {} is no function of the places of the parts",
                    channel.name, channel.function
                );
                Diagnostic::error(Code::BadSetting, message)
                    .help("leave the channel out, or `solver.backend = \"native\"`")
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

    /// The built-in solver as the predictor of a study.
    ///
    /// # Errors
    /// A load that drives nothing the solver can change.
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
