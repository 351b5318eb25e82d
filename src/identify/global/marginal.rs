//! Fit of the identified parameters alone, with tolerances, mark positions and assembly offsets marginalised.
//!
//! The small errors `t` of axle and rig have Gaussian priors `N(0, T)` and act linearly: `r(x, t) = r(x, t0) + J_t (t - t0)`, where `t0` are
//! their fitted values and `x` the identified parameters. With rows of unit noise, the residual is `r(x) = r(x, t0) - J_t t0`. Its covariance
//! is `V = I + A A'` with `A = J_t T^1/2`.
//!
//! The symmetric root `V^-1/2 = I + A U f U' A'` makes the rows independent, with `A'A = U diag(l) U'` and `f = (1/sqrt(1 + l) - 1)/l`. Of all
//! square roots of `V^-1`, the symmetric one changes the rows least, so each row still belongs to one reading. The residual remains a nonlinear
//! function of the identified parameters, with exact derivatives.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::fit::GlobalFit;
use super::gauss_newton::{LeastSquares, Minimum, Prior, Tolerances, minimise};
use super::native::NativePredictor;
use super::observation::{Evaluation, NuisanceLayout, Observations};
use super::predictor::Predictor;
use super::prepared::Prepared;
use super::unknown::FitUnknowns;
use crate::settings::FLAT_PRIOR_SD;
use crate::tolerance::Whitening;
use crate::{IdentifyError, Problem};
use admire_solver::mechanics::eigen::symmetric_eigen;
use admire_solver::model::Model;
use admire_solver::system::{Parameters, State};
use admire_study::Measurement;

/// Result of a joint fit of all unknowns, from which the fit of the identified parameters alone is derived.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Compiled deck of the study.
    pub prepared: Arc<Prepared>,
    /// Unknowns of the deck. The identified parameters come first.
    pub unknowns: FitUnknowns,
    /// Layout of the unknowns of the measurement.
    pub layout: NuisanceLayout,
    /// Values of all unknowns in the joint fit.
    pub x: Vec<f64>,
    /// Prior of each unknown of the joint fit.
    pub priors: Vec<Prior>,
    /// Number of identified parameters.
    pub sought: usize,
    /// Indices of the load cases whose readings form the rows.
    pub cases: Vec<usize>,
    /// Known equilibria of the load cases, each with the parameter values at which it was solved. Empty if none are known.
    pub starts: Vec<(State, Parameters)>,
    /// Transformation of the readings to independent rows; `None` if the readings are independent already.
    pub whitening: Option<Arc<Whitening>>,
    /// Reciprocal standard deviation of each whitened row; zero for a row that is not used.
    pub weights: DVector<f64>,
    /// Derivatives of all rows with respect to all unknowns.
    pub jacobian: DMatrix<f64>,
}

/// Model of the identified parameters with all other unknowns marginalised.
#[derive(Clone, Debug)]
pub struct Marginal {
    joint: Joint,
    /// Indices of the rows that are used, each with its weight.
    used: Vec<(usize, f64)>,
    /// Matrix `A` of the module documentation: whitened effect of each small error of one prior standard deviation.
    small: DMatrix<f64>,
    /// Matrix `U f U'` of the module documentation.
    root: DMatrix<f64>,
    /// Effect of the fitted small errors on the whitened rows: `J_t t0` of the module documentation.
    found: DVector<f64>,
}

impl Marginal {
    /// Derives the model of the identified parameters from a joint fit.
    pub fn new(joint: Joint) -> Self {
        let weights = joint.weights.iter().copied().enumerate();
        let used: Vec<(usize, f64)> = weights.filter(|(_, weight)| *weight > 0.0).collect();
        let small: Vec<usize> = (joint.sought..joint.x.len())
            .filter(|k| joint.priors[*k].sd > 0.0)
            .collect();
        let mut columns = joint.jacobian.select_columns(&small);
        for (mut column, k) in columns.column_iter_mut().zip(&small) {
            // An unknown without a prior gets a very wide prior.
            column *= joint.priors[*k].sd.min(FLAT_PRIOR_SD);
        }
        let columns = picked(&joint, &used, &columns);
        let eigen = symmetric_eigen(columns.tr_mul(&columns));
        let factor = |l: f64| {
            if l > 1e-12 {
                ((1.0 + l).sqrt().recip() - 1.0) / l
            } else {
                -0.5
            }
        };
        let mut scaled = eigen.eigenvectors.clone();
        for (mut column, l) in scaled.column_iter_mut().zip(&eigen.eigenvalues) {
            column *= factor(l.max(0.0));
        }
        let root = scaled * eigen.eigenvectors.transpose();
        let values = DVector::from_iterator(
            small.len(),
            small
                .iter()
                .map(|k| joint.x[*k] / joint.priors[*k].sd.min(FLAT_PRIOR_SD)),
        );
        Self {
            found: &columns * values,
            small: columns,
            root,
            used,
            joint,
        }
    }

    /// Derives the model of the identified parameters from a global fit. The first `sought` unknowns are the identified parameters; all other
    /// unknowns must have priors.
    pub fn of(fit: &GlobalFit<'_>, prepared: Arc<Prepared>, sought: usize) -> Self {
        let global = &fit.problem;
        Self::new(Joint {
            prepared,
            unknowns: global.unknowns.clone(),
            layout: global.layout.clone(),
            x: fit.minimum.x.clone(),
            priors: global.priors(),
            sought,
            cases: global.observations.cases(),
            starts: Vec::new(),
            whitening: None,
            weights: fit.minimum.weights.map(f64::sqrt),
            jacobian: fit.minimum.evaluation.jacobian.clone(),
        })
    }

    /// Returns the number of identified parameters.
    #[expect(clippy::len_without_is_empty, reason = "a fit has unknowns")]
    pub fn len(&self) -> usize {
        self.joint.sought
    }

    /// Iterates over the rows that are used, as indices among all rows of the cases.
    pub fn rows(&self) -> impl Iterator<Item = usize> + '_ {
        self.used.iter().map(|(row, _)| *row)
    }

    /// Returns the readings that the rows are computed from.
    pub fn observations<'m>(
        &self,
        measurement: &'m Measurement,
        model: &Model,
    ) -> Observations<'m> {
        let cases = &self.joint.cases;
        // With whitening, rows that are not used have zero weight. Without whitening, they are left out from the start.
        if self.joint.whitening.is_some() {
            Observations::new(measurement, model, cases)
        } else {
            Observations::fitted(measurement, model, cases)
        }
    }

    /// Returns the values of the identified parameters in the joint fit.
    pub fn start(&self) -> Vec<f64> {
        self.joint.x[..self.len()].to_vec()
    }

    /// Returns the priors of the identified parameters.
    pub fn priors(&self) -> &[Prior] {
        &self.joint.priors[..self.len()]
    }

    /// Returns the natural unit (typical step size) of each identified parameter: its prior standard deviation, at most 1.
    pub fn scale(&self) -> Vec<f64> {
        self.priors()
            .iter()
            .map(|prior| prior.sd.min(1.0))
            .collect()
    }

    /// Creates a least-squares problem for the identified parameters. It has its own predictor, so its results do not depend on other fits.
    ///
    /// # Errors
    /// Fails if the solver cannot change a parameter that a load drives.
    pub fn problem<'a>(
        &'a self,
        problem: &Problem<'a>,
    ) -> Result<MarginalProblem<'a>, IdentifyError> {
        let model = &self.joint.prepared.model;
        let observations = self.observations(problem.measurement, model);
        let mut predictor = self
            .joint
            .prepared
            .native(problem, observations.observed.clone())?;
        for (case, (state, theta)) in self.joint.starts.iter().enumerate() {
            predictor.start_from(case, state.clone(), theta.clone());
        }
        Ok(MarginalProblem {
            unknowns: self.joint.unknowns.clone(),
            deck: self.joint.prepared.system.parameters(),
            shift: None,
            marginal: self,
            observations,
            predictor,
        })
    }

    fn root(&self, rows: DMatrix<f64>) -> DMatrix<f64> {
        let along = &self.root * self.small.tr_mul(&rows);
        rows + &self.small * along
    }
}

/// Returns the used rows of a matrix after whitening and weighting.
fn picked(joint: &Joint, used: &[(usize, f64)], rows: &DMatrix<f64>) -> DMatrix<f64> {
    let turned = joint
        .whitening
        .as_ref()
        .map_or_else(|| rows.clone(), |whitening| whitening.apply(rows));
    DMatrix::from_fn(used.len(), rows.ncols(), |k, column| {
        let (row, weight) = used[k];
        turned[(row, column)] * weight
    })
}

/// Least-squares problem of the identified parameters alone. If the model is right, its residuals are independent with unit variance.
pub struct MarginalProblem<'a> {
    marginal: &'a Marginal,
    unknowns: FitUnknowns,
    deck: Parameters,
    observations: Observations<'a>,
    predictor: NativePredictor<'a>,
    /// Vector subtracted from the residuals, to simulate other readings.
    shift: Option<DVector<f64>>,
}

impl MarginalProblem<'_> {
    /// Simulates other readings: `shift` is subtracted from the residuals of all later evaluations.
    pub fn shift(&mut self, shift: DVector<f64>) {
        self.shift = Some(shift);
    }

    /// Fits the identified parameters from `start` with the given priors. Returns `None` if the model has no solution at the start.
    pub fn minimise(
        &mut self,
        start: &[f64],
        priors: &[Prior],
        tolerances: Tolerances,
    ) -> Option<Minimum> {
        let scale = self.marginal.scale();
        let held: Vec<bool> = priors.iter().map(|prior| prior.sd <= 0.0).collect();
        minimise(self, start, priors, &scale, &held, tolerances)
    }
}

impl LeastSquares for MarginalProblem<'_> {
    fn evaluate(&mut self, x: &[f64], with_jacobian: bool) -> Option<Evaluation> {
        let joint = &self.marginal.joint;
        let mut all = joint.x.clone();
        all[..x.len()].copy_from_slice(x);
        let own = self.unknowns.len();
        let numbers = self.unknowns.numbers(&self.deck, &all[..own]);
        let directions = with_jacobian.then(|| {
            let mut all = self.unknowns.directions(&numbers.theta, &all[..own]);
            all.truncate(x.len());
            all
        });
        let prediction = self.predictor.predict(&numbers, directions.as_deref());
        if with_jacobian {
            let shares = self.predictor.shares(&self.unknowns.springs());
            self.unknowns.set_load_shares(&shares.unwrap_or_default());
        }
        let columns = if with_jacobian { all.len() } else { 0 };
        let found = self
            .observations
            .evaluate(&prediction, &joint.layout, &all, columns)?;
        let used = &self.marginal.used;
        let residual =
            DMatrix::from_column_slice(found.residual.len(), 1, found.residual.as_slice());
        let mut residual = picked(joint, used, &residual);
        for (to, small) in residual.iter_mut().zip(self.marginal.found.iter()) {
            *to -= small;
        }
        let mut residual = self.marginal.root(residual).column(0).into_owned();
        if let Some(shift) = &self.shift {
            residual -= shift;
        }
        let jacobian = if with_jacobian {
            let own = found.jacobian.columns(0, x.len()).into_owned();
            self.marginal.root(picked(joint, used, &own))
        } else {
            DMatrix::zeros(residual.len(), 0)
        };
        Some(Evaluation {
            residual,
            jacobian,
            free: Vec::new(),
        })
    }

    fn checkpoint(&mut self) {
        self.predictor.checkpoint();
    }

    fn rollback(&mut self) {
        self.predictor.rollback();
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
}
