//! Least-squares problem of a fit, with all unknowns of the deck and of the measurement.

use nalgebra::DVector;

use super::gauss_newton::{LeastSquares, Minimum, Prior};
use super::observation::{Evaluation, NuisanceLayout, Observations, Row};
use super::predictor::Predictor;
use super::unknown::FitUnknowns;
use crate::settings::HUBER_THRESHOLD_SIGMA;
use admire_solver::system::Parameters;
use admire_study::settings::Loss;

/// Callback that observes a fit and returns `false` to stop it. Its arguments are the number of accepted steps, the number of sweeps over all
/// load cases so far, and the objective.
pub type Watch<'a> = dyn FnMut(usize, usize, f64) -> bool + 'a;

/// Least-squares problem of a fit: unknowns of deck and measurement, the predictor, and the readings.
pub struct GlobalProblem<'a> {
    /// Parameter values of the deck before any unknown is applied.
    pub deck: Parameters,
    /// Unknowns of the deck. They come first in the vector of all unknowns.
    pub unknowns: FitUnknowns,
    /// Unknowns of the measurement. They come last in the vector of all unknowns.
    pub layout: NuisanceLayout,
    /// Readings that are compared with the predictions.
    pub observations: Observations<'a>,
    /// Predictor of the readings.
    pub predictor: Box<dyn Predictor + 'a>,
    /// Loss function of the residuals.
    pub loss: Loss,
    /// Values of the deck unknowns at the start and after every accepted step.
    pub history: Vec<Vec<f64>>,
    /// Callback that may stop the fit.
    pub watch: Option<Box<Watch<'a>>>,
}

impl GlobalProblem<'_> {
    /// Returns the number of unknowns of deck and measurement together.
    pub fn dimension(&self) -> usize {
        self.unknowns.len() + self.layout.sd.len()
    }

    /// Returns the starting values of all unknowns.
    pub fn start(&self) -> Vec<f64> {
        let mut x = self.unknowns.start();
        x.resize(self.dimension(), 0.0);
        x
    }

    /// Returns the priors of all unknowns.
    pub fn priors(&self) -> Vec<Prior> {
        let deck = self.unknowns.list().iter().map(|unknown| Prior {
            mean: unknown.mean,
            sd: unknown.sd,
        });
        let own = self.layout.sd.iter().map(|sd| Prior { mean: 0.0, sd: *sd });
        deck.chain(own).collect()
    }

    /// Returns the natural unit of each unknown: its prior standard deviation, at most 1. For a stiffness, 1 is a change by a factor of e.
    pub fn scale(&self) -> Vec<f64> {
        let natural = |prior: Prior| {
            if prior.sd.is_finite() {
                prior.sd.min(1.0)
            } else {
                1.0
            }
        };
        self.priors().into_iter().map(natural).collect()
    }

    /// Calls the watch callback after the fit has ended. Returns false if the callback stops all further work on the result.
    pub(crate) fn goes_on(&mut self, minimum: &Minimum) -> bool {
        let sweeps = self.predictor.sweeps();
        self.watch
            .as_mut()
            .is_none_or(|watch| watch(minimum.iterations, sweeps, minimum.objective))
    }

    /// Returns for each unknown whether it is held, because its prior has zero width.
    pub fn held(&self) -> Vec<bool> {
        self.priors()
            .into_iter()
            .map(|prior| prior.sd <= 0.0)
            .collect()
    }
}

impl LeastSquares for GlobalProblem<'_> {
    fn evaluate(&mut self, x: &[f64], with_jacobian: bool) -> Option<Evaluation> {
        let numbers = self.unknowns.numbers(&self.deck, x);
        let directions = with_jacobian.then(|| self.unknowns.directions(&numbers.theta, x));
        let prediction = self.predictor.predict(&numbers, directions.as_deref());
        if with_jacobian {
            let shares = self.predictor.shares(&self.unknowns.springs());
            self.unknowns.set_load_shares(&shares.unwrap_or_default());
        }
        let columns = if with_jacobian { x.len() } else { 0 };
        self.observations
            .evaluate(&prediction, &self.layout, x, columns)
    }

    fn checkpoint(&mut self) {
        self.predictor.checkpoint();
    }

    fn rollback(&mut self) {
        self.predictor.rollback();
    }

    /// Returns Huber's weights. All three coordinates of a mark get the same weight, from the norm of its residual, so a wrong mark is
    /// downweighted as a whole.
    fn weights(&self, residual: &DVector<f64>) -> DVector<f64> {
        let mut weights = DVector::from_element(residual.len(), 1.0);
        if self.loss == Loss::Gaussian {
            return weights;
        }
        for (at, row) in self.observations.rows.iter().enumerate() {
            let (size, count) = match row {
                Row::Mark { axis: 0, .. } => (residual.rows(at, 3).norm() / 3f64.sqrt(), 3),
                Row::Mark { .. } => continue,
                Row::Wheel { .. } | Row::Channel { .. } => (residual[at].abs(), 1),
            };
            let weight = if size <= HUBER_THRESHOLD_SIGMA {
                1.0
            } else {
                HUBER_THRESHOLD_SIGMA / size
            };
            weights.rows_mut(at, count).fill(weight);
        }
        weights
    }

    fn retract(&self, x: &[f64], step: &DVector<f64>) -> Vec<f64> {
        self.unknowns.moved(x, step)
    }

    fn step_to(&self, from: &[f64], to: &[f64]) -> DVector<f64> {
        self.unknowns.step_to(from, to)
    }

    fn limits(&self, scale: &[f64], reach: f64) -> (Vec<f64>, Vec<f64>) {
        self.unknowns.limits(scale, reach)
    }

    fn bounds(&self, x: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        self.unknowns.bounds(x)
    }

    fn progress(&mut self, iteration: usize, x: &[f64], objective: f64) -> bool {
        self.history.push(x[..self.unknowns.len()].to_vec());
        let sweeps = self.predictor.sweeps();
        self.watch
            .as_mut()
            .is_none_or(|watch| watch(iteration, sweeps, objective))
    }
}
