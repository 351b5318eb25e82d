//! Residuals of an extended fit as a function of its unknowns.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::DVector;

use super::background::Background;
use super::effort::Effort;
use super::setup::Setup;
use crate::identify::global::gauss_newton::LeastSquares;
use crate::identify::global::{Direction, Evaluation, NativePredictor, Observations, Predictor};
use crate::mechanics::{Mat3, Vec3, exp, psi_theta_phi};
use crate::system::{Parameters, Slot};

/// Turns below this, in units of their prior, count as this.
const LEAST_TURN: f64 = 1e-7;

pub(super) struct FitProblem<'a> {
    pub(super) setup: &'a Setup,
    pub(super) observations: Observations<'a>,
    pub(super) predictor: NativePredictor<'a>,
    pub(super) weights: DVector<f64>,
    pub(super) background: Option<Arc<Background>>,
    /// Residuals of the last evaluation before they were whitened.
    pub(super) misfit: DVector<f64>,
    /// The unknowns the predictor was asked for last.
    pub(super) last: Vec<f64>,
    pub(super) effort: Effort,
    /// After the last accepted step.
    pub(super) objective: f64,
}

impl FitProblem<'_> {
    /// Euler angles of the markers that turn, and how fast they do.
    fn turn(&self, theta: &mut Parameters, x: &[f64]) -> BTreeMap<usize, Vec<(Slot, f64)>> {
        let mut rates = BTreeMap::new();
        for (at, turn, slots) in &self.setup.turns {
            let mut rate = Vec::new();
            for ((marker, _), slots) in turn.markers.iter().zip(slots) {
                let sd = super::hypothesis::TURN_SD;
                let axis = Vec3::ith(turn.axis, 1.0);
                // Where the tilt vanishes psi and phi are one; a turn of nearly nothing tells them apart.
                let angle = if x[*at].abs() < LEAST_TURN {
                    LEAST_TURN
                } else {
                    x[*at]
                } * sd;
                let R: Mat3 = theta.marker(*marker).R * exp(&(axis * angle));
                let angles = psi_theta_phi(&R);
                if turn.axis == 2 {
                    // The last of the three angles is about the marker's own z.
                    theta.set(slots[2], theta.get(slots[2]) + angle);
                    rate.push((slots[2], sd));
                    continue;
                }
                for (slot, angle) in slots.iter().zip(angles) {
                    theta.set(*slot, angle);
                }
                let (psi, tilt) = (angles[0], angles[1]);
                let axes = Mat3::from_columns(&[
                    Vec3::z(),
                    Vec3::new(psi.cos(), psi.sin(), 0.0),
                    Vec3::new(psi.sin() * tilt.sin(), -psi.cos() * tilt.sin(), tilt.cos()),
                ]);
                if let Some(inverse) = axes.try_inverse() {
                    let by_angle = inverse * (R * axis) * sd;
                    rate.extend(slots.iter().copied().zip(by_angle.iter().copied()));
                }
            }
            rates.insert(*at, rate);
        }
        rates
    }
}

impl LeastSquares for FitProblem<'_> {
    fn evaluate(&mut self, x: &[f64], with_jacobian: bool) -> Option<Evaluation> {
        let setup = self.setup;
        let count = setup.unknowns.len();
        let mut numbers = setup.unknowns.numbers(&setup.deck, &x[..count]);
        let rates = self.turn(&mut numbers.theta, x);
        let mut directions: Option<Vec<Direction>> =
            with_jacobian.then(|| setup.unknowns.directions(&numbers.theta, &x[..count]));
        if let Some(directions) = &mut directions {
            for (at, rate) in rates {
                directions[at].always = rate;
            }
        }
        self.last = x.to_vec();
        let prediction = self.predictor.predict(&numbers, directions.as_deref());
        let inner = count + setup.layout.sd.len();
        let mut out =
            self.observations
                .evaluate(&prediction, &setup.layout, &x[..inner], with_jacobian)?;
        let columns = out.jacobian.ncols();
        if with_jacobian {
            out.jacobian = out
                .jacobian
                .resize_horizontally(columns + setup.rows.len(), 0.0);
        }
        for (k, column) in setup.rows.iter().enumerate() {
            for (row, value) in column {
                out.residual[*row] += value * x[inner + k];
                if with_jacobian {
                    out.jacobian[(*row, inner + k)] = *value;
                }
            }
        }
        self.misfit.clone_from(&out.residual);
        if let Some(background) = &self.background {
            background.whiten(&mut out.residual);
            background.whiten_columns(&mut out.jacobian);
        }
        Some(out)
    }

    fn weights(&self, _residual: &DVector<f64>) -> DVector<f64> {
        self.weights.clone()
    }

    fn moved(&self, x: &[f64], step: &DVector<f64>) -> Vec<f64> {
        self.setup.unknowns.moved(x, step)
    }

    fn limits(&self, scale: &[f64], reach: f64) -> (Vec<f64>, Vec<f64>) {
        self.setup.unknowns.limits(scale, reach)
    }

    fn progress(&mut self, iteration: usize, _x: &[f64], objective: f64) -> bool {
        let before = std::mem::replace(&mut self.objective, objective);
        !self.effort.is_enough(iteration, (before, objective))
    }
}
