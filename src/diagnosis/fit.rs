//! Joint fit of an extended deck's stiffnesses, causes and tolerances, with variance components estimated by maximum evidence.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::candidate_effect::{CandidateEffect, Parametrisation, Term};
use super::cause::Cause;
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::early_stopping::EarlyStopping;
pub use super::estimate::Estimate;
use super::extended_deck::{ExtendedDeck, deck_of, like};
use super::settle::{Settled, Sweep};
use super::unknowns::{Known, Unknowns};
use crate::settings::{
    CONVERGED_NATS, MAX_FIT_ITERATIONS, NEGLIGIBLE_GAIN_NATS, WRONG_MINIMUM_RMS_SIGMA,
};
use admire_identify::global::{
    FitUnknowns, HysteresisState, NativePredictor, NuisanceLayout, Observations, Predictor,
};
use admire_identify::tolerance::{
    LinearModel, Posterior, RowsByVarianceClass, VarianceComponents, Whitening,
};
use admire_identify::{Problem, Unknown, tolerance};
use admire_solver::system::{Parameters, State};

/// Fitted model, linearised at the end of its fit, with its posterior.
#[derive(Clone, Debug)]
pub struct FittedModel {
    /// Extended deck. Fits with the same structure share it.
    pub deck: Arc<ExtendedDeck>,
    /// Effects in the model.
    pub effects: Vec<CandidateEffect>,
    /// Unknowns of the deck: stiffnesses, random effects and parameters of causes.
    pub unknowns: FitUnknowns,
    /// Unknowns of the measurement: poses of the measuring frame and positions of marks.
    pub layout: NuisanceLayout,
    /// Values of all unknowns.
    pub x: Vec<f64>,
    /// Priors of all unknowns.
    pub priors: Vec<tolerance::Coefficient>,
    /// Prediction minus reading of all rows, in units of the declared noise.
    pub residual: DVector<f64>,
    /// Derivatives of `residual` with respect to all unknowns.
    pub jacobian: DMatrix<f64>,
    /// Whitening transformation, which makes the residual rows independent.
    pub whitening: Arc<Whitening>,
    /// Linear model at the end of the fit.
    pub linear: Arc<LinearModel>,
    /// Variance components: standard deviations of the tolerance groups and noise scales.
    pub sizes: VarianceComponents,
    /// Posterior of the linear model.
    pub posterior: Posterior,
    /// Index of each parameter of each effect among all unknowns.
    pub parameter_index: Vec<Vec<usize>>,
    /// Deck parameters of each load case.
    pub thetas: Vec<Parameters>,
    /// Equilibrium of each load case.
    pub states: Vec<State>,
    /// History variables of laws with memory.
    pub memories: Vec<HysteresisState>,
}

impl FittedModel {
    /// Returns the whitened residual (reading minus prediction) at the optimum of the linear model, and the whitened Jacobian. Both use the
    /// fit's variance components. The residual at the end of the fit is not used: the remaining step to the optimum would look like
    /// structure along directions that the fit absorbs.
    pub fn whitened(&self) -> (DVector<f64>, DMatrix<f64>) {
        self.whitened_at(&self.sizes, &self.posterior)
    }

    /// Returns the whitened residual and Jacobian as [`Self::whitened`] does, but at the variance components `sizes` and with their
    /// `posterior`.
    pub fn whitened_at(
        &self,
        sizes: &VarianceComponents,
        posterior: &Posterior,
    ) -> (DVector<f64>, DMatrix<f64>) {
        let weights = self.whitening.weights(&sizes.ln);
        let end = &self.residual + &self.jacobian * &posterior.step;
        let residual = self.whitening.apply_vector(&-end).component_mul(&weights);
        let mut jacobian = self.whitened_jacobian();
        for (mut row, weight) in jacobian.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        (residual, jacobian)
    }

    /// Returns true for an unknown that is a stiffness or a parameter of a cause, false for a plain random effect.
    pub fn is_of_the_model(&self, unknown: usize) -> bool {
        self.priors[unknown].group.is_none()
            || self
                .parameter_index
                .iter()
                .flatten()
                .any(|at| *at == unknown)
    }

    /// Returns the log prior odds of the effects in the model.
    pub fn ln_prior(&self) -> f64 {
        CandidateEffect::ln_prior_of(&self.effects)
    }

    /// Returns the log posterior probability of the model, up to a constant: log evidence plus log prior odds. If the fit ended before its
    /// optimum, the gain predicted for the remaining step is subtracted from the log evidence.
    pub fn ln_posterior(&self) -> f64 {
        let left = Some(self.posterior.gain).filter(|gain| *gain > NEGLIGIBLE_GAIN_NATS);
        self.posterior.ln_z - left.unwrap_or(0.0) + self.ln_prior()
    }

    /// Returns true if the fit ended near the optimum of its linear model, false if it stopped early and far from it.
    pub fn is_converged(&self) -> bool {
        self.posterior.gain < CONVERGED_NATS
    }

    /// Returns the estimates of all parameters of effect `chosen`.
    pub fn estimates(&self, chosen: usize) -> Vec<Estimate> {
        let hypothesis = &self.effects[chosen];
        let covariance = &self.posterior.covariance;
        hypothesis
            .numbers
            .iter()
            .zip(&self.parameter_index[chosen])
            .map(|(number, &at)| {
                let (x, sd) = (self.x[at], covariance[(at, at)].max(0.0).sqrt());
                let (value, std_error) = match number.unknown {
                    Parametrisation::Compliance(_) => (libm::exp(-x), libm::exp(-x) * sd),
                    Parametrisation::Rate { .. } => (libm::exp(x), libm::exp(x) * sd),
                    Parametrisation::SlipLength { .. } => {
                        let first = self.parameter_index[chosen][0];
                        let force = self.x[first];
                        let scale = hypothesis.numbers[0].sd;
                        let stiffness = force * scale / libm::exp(x);
                        // d ln(force / length) = d force / force - d ln length.
                        let relative = covariance[(first, first)] / (force * force)
                            + covariance[(at, at)]
                            - 2.0 * covariance[(first, at)] / force;
                        (stiffness, stiffness.abs() * relative.max(0.0).sqrt())
                    }
                    Parametrisation::Offset { .. } | Parametrisation::Member(_) => (x, sd),
                    _ => (x * number.sd, sd * number.sd),
                };
                Estimate {
                    name: number.name.clone(),
                    value: value * number.unit,
                    std_error: std_error * number.unit,
                }
            })
            .collect()
    }

    /// Returns true if the estimate violates the sign constraint of effect `chosen`. The main term of a cause may be negative by up to two
    /// standard errors. Further terms and free play may not be negative: negative play would be compliance of the link.
    pub fn has_wrong_sign(&self, chosen: usize) -> bool {
        let hypothesis = &self.effects[chosen];
        let at = self.parameter_index[chosen][0];
        hypothesis.one_sided
            && !matches!(
                hypothesis.numbers[0].unknown,
                Parametrisation::Compliance(_)
            )
            && self.x[at]
                < match hypothesis.term {
                    Term::Main if hypothesis.cause != Cause::FreePlay => {
                        -2.0 * self.posterior.covariance[(at, at)].max(0.0).sqrt()
                    }
                    _ => 0.0,
                }
    }

    /// Returns the estimate and the standard error of unknown `k` of the study, in the unit of the unknown. `unknown` is the definition of
    /// that unknown.
    pub fn identified(&self, k: usize, unknown: &Unknown) -> (f64, f64) {
        let x = self.x[k];
        (
            unknown.value(x),
            unknown.value_rate(x) * self.coordinate_sd(k),
        )
    }

    /// Returns the standard error of the coordinate of unknown `k`. The coordinate is a logarithm, or a change in units of its prior
    /// standard deviation.
    pub fn coordinate_sd(&self, k: usize) -> f64 {
        self.posterior.covariance[(k, k)].max(0.0).sqrt()
    }

    /// Returns the effect of one cause on each residual row, including further terms of its law: the prediction minus the prediction without
    /// the cause. Stiffnesses, tolerances and other causes keep their values. Returns `None` if a case has no equilibrium without the cause.
    pub fn effect(&self, subject: &DiagnosisProblem<'_>, chosen: usize) -> Option<DVector<f64>> {
        let inner = self.unknowns.len() + self.layout.sd.len();
        let mut x = self.x.clone();
        for (h, places) in self.effects.iter().zip(&self.parameter_index) {
            if !h.same_site(&self.effects[chosen]) {
                continue;
            }
            for (number, at) in h.numbers.iter().zip(places) {
                x[*at] = number.absent(x[*at]);
            }
        }
        let on_rows = self.jacobian.columns_range(inner..);
        let change = DVector::from_fn(self.x.len() - inner, |k, _| {
            self.x[inner + k] - x[inner + k]
        });
        let mut effect = on_rows * change;
        if x[..inner] != self.x[..inner] {
            let problem = Problem {
                dataset: &self.deck.dataset,
                model: &self.deck.model,
                ..subject.problem.clone()
            };
            let mut predictor = self.predictor(&problem)?;
            let numbers = self.unknowns.numbers(
                &self.deck.prepared.system.parameters(),
                &x[..self.unknowns.len()],
            );
            let prediction = predictor.predict(&numbers, None);
            subject.count_sweeps(1);
            let cases: Vec<usize> = (0..self.states.len()).collect();
            let rows = Observations::new(problem.measurement, problem.model, &cases);
            let without = rows
                .evaluate(&prediction, &self.layout, &x[..inner], 0)?
                .residual;
            effect +=
                &self.residual - on_rows * DVector::from_column_slice(&self.x[inner..]) - without;
        }
        Some(effect)
    }

    /// Returns a predictor for all cases of the extended deck. It starts from the fitted equilibria.
    pub(super) fn predictor<'p>(&'p self, problem: &'p Problem<'p>) -> Option<NativePredictor<'p>> {
        let cases: Vec<usize> = (0..self.states.len()).collect();
        let observed = Observations::new(problem.measurement, problem.model, &cases).observed;
        let prepared = &self.deck.prepared;
        let native = prepared.native(problem, observed).ok()?;
        let mut predictor = native.remembering(self.memories.clone());
        let parameters = prepared.system.parameters();
        for (case, state) in self.states.iter().enumerate() {
            predictor.start_from(case, state.clone(), parameters.clone());
        }
        Some(predictor)
    }

    /// Conditions the linear model of this fit on the rows that `whitening` includes, at the same variance components. Returns the residual
    /// (prediction minus reading) at the new optimum, and the posterior. No equilibrium is solved.
    pub fn relinearised_on(&self, whitening: &Whitening) -> Option<(DVector<f64>, Posterior)> {
        self.relinearised_with_offset(whitening, &DVector::zeros(self.residual.len()))
    }

    /// Adds `off` to the predictions, and conditions the linear model of this fit on the rows that `whitening` includes. Returns the
    /// residual (prediction minus reading) at the new optimum, and the posterior.
    pub fn relinearised_with_offset(
        &self,
        whitening: &Whitening,
        off: &DVector<f64>,
    ) -> Option<(DVector<f64>, Posterior)> {
        let misfit = &self.residual + off;
        let linear = LinearModel::new(
            whitening,
            &RowsByVarianceClass::new(whitening, &whitening.apply(&self.jacobian)),
            &whitening.apply_vector(&-&misfit),
            self.priors.clone(),
            DVector::from_column_slice(&self.x),
        );
        let posterior = linear.posterior(&self.sizes)?;
        let misfit = misfit + &self.jacobian * &posterior.step;
        Some((misfit, posterior))
    }

    /// Computes the Jacobian of the decorrelated rows, before scaling to unit variance. The result is not stored, because a search keeps
    /// many fits.
    pub fn whitened_jacobian(&self) -> DMatrix<f64> {
        self.whitening.apply(&self.jacobian)
    }

    /// Computes the residual (reading minus prediction) in the decorrelated rows, before scaling to unit variance.
    pub fn whitened_residual(&self) -> DVector<f64> {
        self.whitening.apply_vector(&-&self.residual)
    }

    /// Leaves some rows out of the linear model. Returns the residual of all rows at its optimum (prediction minus reading) and its log
    /// evidence. `jacobian` and `residual` (reading minus prediction) are in decorrelated rows. The marks of one part in one case must be
    /// left out together.
    pub fn evidence_without(
        &self,
        jacobian: &DMatrix<f64>,
        residual: &DVector<f64>,
        left_out: &[bool],
    ) -> Option<(DVector<f64>, f64)> {
        let linear = self
            .linear
            .without(&self.whitening, jacobian, residual, left_out);
        let reached = linear.solve(&self.sizes, 0.0)?;
        let misfit = &self.residual + &self.jacobian * &reached.step;
        Some((misfit, reached.ln_z))
    }
}

/// Fits the deck extended by the `chosen` effects. Each effect comes with guesses of its parameters, in units of their priors. Values from
/// the earlier fit `warm`, where available, replace the guesses. Returns `None` if the extended deck cannot be compiled or solved.
pub(super) fn fit(
    subject: &DiagnosisProblem<'_>,
    chosen: &[(CandidateEffect, Vec<f64>)],
    warm: Option<(&FittedModel, &[f64])>,
    data: Data,
) -> Option<FittedModel> {
    let fitted = fit_with_early_stopping(subject, chosen, warm, data, EarlyStopping::NONE)?;
    Some(Arc::unwrap_or_clone(fitted))
}

/// Fits the extended deck as [`fit`] does, but stops early under the condition of `stopping`. Variance components start from `warm`, if
/// given, otherwise from the prior medians of the study. If unknowns end beyond their bounds, the fit is repeated with the furthest one
/// fixed at its bound, until all are within their bounds.
pub(super) fn fit_with_early_stopping(
    subject: &DiagnosisProblem<'_>,
    chosen: &[(CandidateEffect, Vec<f64>)],
    warm: Option<(&FittedModel, &[f64])>,
    data: Data,
    stopping: EarlyStopping,
) -> Option<Arc<FittedModel>> {
    let mut held = Vec::new();
    loop {
        let fitted = fit_within(subject, chosen, (warm, &held), data, stopping)?;
        match fitted.unknowns.furthest_beyond_bounds(&fitted.x, &held) {
            Some(beyond) => held.push(beyond),
            None => return Some(fitted),
        }
    }
}

/// Fits the extended deck with some unknowns fixed. `held` lists their indices and coordinates.
fn fit_within(
    subject: &DiagnosisProblem<'_>,
    chosen: &[(CandidateEffect, Vec<f64>)],
    (warm, held): (Option<(&FittedModel, &[f64])>, &[(usize, f64)]),
    data: Data,
    stopping: EarlyStopping,
) -> Option<Arc<FittedModel>> {
    let chosen = &apart(chosen)[..];
    let parent = warm.filter(|warm| is_submodel_start(*warm, chosen));
    let sizes = warm.map_or(&subject.sizes, |(fitted, _)| &fitted.sizes);
    let deck = deck_of(
        subject,
        chosen,
        warm.map(|(fitted, _)| (fitted.effects.as_slice(), &fitted.deck)),
    )?;
    let problem = Problem {
        dataset: &deck.dataset,
        model: &deck.model,
        ..subject.problem.clone()
    };
    let known = warm.map(|(fitted, x)| Known {
        unknowns: &fitted.unknowns,
        chosen: &fitted.effects,
        places: &fitted.parameter_index,
        x,
    });
    let mut unknowns = Unknowns::new(subject, &problem, &deck.prepared, chosen, known)?;
    unknowns.hold(held);
    let cases: Vec<usize> = (0..problem.measurement.cases.len()).collect();
    let whitening = subject.whitening(data);
    // Each start has its own predictor, because a predictor starts from its latest equilibria.
    let begun = || {
        let observations = Observations::new(problem.measurement, &deck.model, &cases);
        let predictor = deck
            .prepared
            .native(&problem, observations.observed.clone())
            .ok()?
            .remembering(unknowns.memories.clone());
        Some(Sweep {
            of_the_model: unknowns.of_the_model(),
            on_rows: Vec::new(),
            unknowns: &unknowns,
            observations,
            predictor,
            whitening: &whitening,
            stiffnesses: subject.problem.unknowns.len(),
            progress: subject.progress(),
        })
    };
    let x = unknowns.start.clone();
    let (sweep, end) = if let Some((warm, _)) = warm {
        let mut sweep = begun()?;
        for (case, state) in warm.states.iter().enumerate() {
            let state = like(&deck, state, &warm.deck);
            sweep
                .predictor
                .start_from(case, state, unknowns.deck.clone());
        }
        // Large variance components are lowered before the fit, so that a new cause can take up effects that they had absorbed. A refit of
        // the same causes keeps them.
        let is_again = parent.is_some_and(|(parent, _)| parent.effects.len() == chosen.len());
        let first = if is_again {
            sizes.clone()
        } else {
            sizes.at(sizes.capped_above_median(1.0))
        };
        let start = sweep.beside(x, (&warm.jacobian, warm.unknowns.len()));
        let is_free = parent.is_some();
        let end = start
            .and_then(|start| sweep.settle(start, &first, (MAX_FIT_ITERATIONS, stopping), is_free));
        subject.count_sweeps(sweep.predictor.sweeps());
        (sweep, end)
    } else {
        // Two starts are compared by evidence. The first start is a fit of the stiffnesses alone. It treats everything else as exact, and
        // can end in a wrong minimum. The second start is a joint fit from the initial values. It fails as often, but in other studies. The
        // second start is skipped if the stiffnesses alone nearly explain the readings.
        let from = |alone: bool, stopping: EarlyStopping| {
            let (mut sweep, mut x) = (begun()?, x.clone());
            if alone {
                sweep.stiffnesses_alone(&mut x);
            }
            let steps = if alone {
                MAX_FIT_ITERATIONS
            } else {
                2 * MAX_FIT_ITERATIONS
            };
            let start = sweep.at(x);
            let missed = start.as_ref().is_none_or(|start| {
                let residual = &start.residual;
                residual.norm_squared()
                    > WRONG_MINIMUM_RMS_SIGMA * WRONG_MINIMUM_RMS_SIGMA * residual.len() as f64
            });
            let end = start.and_then(|start| sweep.settle(start, sizes, (steps, stopping), alone));
            subject.count_sweeps(sweep.predictor.sweeps());
            Some((sweep, end, missed))
        };
        let (sweep, first, missed) = from(true, stopping)?;
        let to_beat = first.as_ref().map_or(f64::NEG_INFINITY, Settled::reached);
        let second = missed
            .then(|| from(false, EarlyStopping { lead: to_beat }))
            .flatten()
            .filter(|(_, end, _)| end.as_ref().is_some_and(|own| own.reached() > to_beat));
        match second {
            Some((sweep, end, _)) => (sweep, end),
            None => (sweep, first),
        }
    };
    let settled = end?;
    let (mut thetas, mut states) = (Vec::new(), Vec::new());
    for case in cases {
        let (state, theta) = sweep.predictor.answer(case)?;
        states.push(state.clone());
        thetas.push(theta.clone());
    }
    let (x, misfit, jacobian, linear) = settled.point.into_parts();
    Some(Arc::new(FittedModel {
        effects: chosen.iter().map(|(h, _)| h.clone()).collect(),
        x,
        residual: misfit,
        jacobian,
        linear: Arc::new(linear),
        sizes: settled.sizes,
        posterior: settled.posterior,
        priors: unknowns.priors,
        unknowns: unknowns.list,
        layout: unknowns.layout,
        parameter_index: unknowns.places,
        memories: unknowns.memories,
        whitening,
        thetas,
        states,
        deck,
    }))
}

/// Returns true if the fit is converged and contains all `chosen` causes, and if `x` are the fit's own unknowns.
fn is_submodel_start(
    (fitted, x): (&FittedModel, &[f64]),
    chosen: &[(CandidateEffect, Vec<f64>)],
) -> bool {
    let is_held =
        |(h, _): &(CandidateEffect, Vec<f64>)| fitted.effects.iter().any(|own| own.same_form(h));
    fitted.is_converged() && fitted.x == x && chosen.iter().all(is_held)
}

/// Splits combined candidates into their main and further terms, each with its own guesses.
fn apart(chosen: &[(CandidateEffect, Vec<f64>)]) -> Vec<(CandidateEffect, Vec<f64>)> {
    let each = |(h, guesses): &(CandidateEffect, Vec<f64>)| {
        let mut left = guesses.as_slice();
        let own = |h: CandidateEffect| {
            let (own, rest) = left.split_at(h.numbers.len());
            left = rest;
            (h, own.to_vec())
        };
        h.split().into_iter().map(own).collect::<Vec<_>>()
    };
    chosen.iter().flat_map(each).collect()
}

/// Fits the model of an earlier fit again, to other data or with other weights. The refit starts from the end of the earlier fit.
pub(super) fn refit(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
    data: Data,
) -> Option<FittedModel> {
    let from = Some((fitted, fitted.x.as_slice()));
    fit(subject, &with_zero_guesses(fitted), from, data)
}

/// Returns the effects of a fit with zero guesses of their parameters. A new fit that starts from `fitted` replaces these guesses by its
/// values.
pub fn with_zero_guesses(fitted: &FittedModel) -> Vec<(CandidateEffect, Vec<f64>)> {
    let zeros = |h: &CandidateEffect| (h.clone(), vec![0.0; h.numbers.len()]);
    fitted.effects.iter().map(zeros).collect()
}
