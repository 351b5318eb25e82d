//! A study's deck compiled with what a fit needs of it.

use super::channel::{Channels, with_channels};
use super::native::{Loads, NativePredictor};
use super::predictor::Observed;
use crate::backend::{BackendError, compile, slot};
use crate::identify::{IdentifyError, Problem};
use crate::model::Model;
use crate::system::System;

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

    /// The same for a deck that another program solves: what the built-in solver cannot solve is left to it.
    ///
    /// # Errors
    /// A channel whose function cannot be read.
    pub fn external(problem: &Problem<'_>) -> Result<Self, IdentifyError> {
        let (model, channels) = with_channels(problem.model, problem.measurement, &[])
            .map_err(|diagnostic| BackendError::NotSolvable(vec![diagnostic]))?;
        let system = System::compile(&model).value;
        Ok(Self {
            model,
            channels,
            system,
        })
    }

    /// The loads of a study as slots.
    ///
    /// # Errors
    /// A load that drives nothing the solver can change.
    pub fn loads(&self, problem: &Problem<'_>) -> Result<Loads, IdentifyError> {
        let loads = &problem.programme.loads;
        let slots = loads
            .iter()
            .map(|load| slot(&self.system, &load.target))
            .collect::<Result<_, _>>()?;
        Ok(Loads {
            slots,
            cases: problem
                .programme
                .cases
                .iter()
                .map(|case| case.values.clone())
                .collect(),
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
        Ok(NativePredictor::new(
            &self.system,
            self.loads(problem)?,
            observed,
            self.channels,
        ))
    }
}
