//! The deck with some causes in it, fitted jointly with stiffnesses, tolerances and their sizes.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::aim::Aim;
use super::cause::Cause;
use super::diagnosis_problem::{Data, DiagnosisProblem};
pub use super::estimate::Estimate;
use super::extended_deck::{ExtendedDeck, deck_of, like};
use super::hypothesis::{Hypothesis, Parametrisation};
use super::settle::{End, Settled, Sweep};
use super::unknowns::{Known, Unknowns};
use admire_identify::global::{
    FitUnknowns, HysteresisState, NativePredictor, NuisanceLayout, Observations, Predictor,
};
use admire_identify::tolerance::{
    LinearModel, Posterior, RowsByVarianceClass, VarianceComponents, Whitening,
};
use admire_identify::{Problem, tolerance};
use admire_solver::system::{Parameters, State};

/// Steps of a fit at most.
const STEPS: usize = 16;
/// Stiffnesses alone that miss the readings by more than so many times their noise may be in a wrong minimum, which tolerances that grow
/// would hide.
const MISSED: f64 = 1.3;

/// A fit has converged if its linear model promises less than so many nats.
const SETTLED: f64 = 1.0;

/// A model linearised where its fit ended, and what the readings say there.
#[derive(Clone, Debug)]
pub struct FittedModel {
    /// The deck; fits of the same structure share it.
    pub deck: Arc<ExtendedDeck>,
    /// What is in it.
    pub effects: Vec<Hypothesis>,
    /// Unknowns of the deck: stiffnesses, members of the tolerance layer, numbers of causes.
    pub unknowns: FitUnknowns,
    /// Unknowns of the measurement.
    pub layout: NuisanceLayout,
    /// Values of all unknowns.
    pub x: Vec<f64>,
    /// Priors of all unknowns.
    pub priors: Vec<tolerance::Coefficient>,
    /// Prediction minus reading of all rows in units of the declared noise.
    pub residual: DVector<f64>,
    /// Its derivative by all unknowns.
    pub jacobian: DMatrix<f64>,
    /// What turned the rows.
    pub whitening: Arc<Whitening>,
    /// The linear model.
    pub linear: Arc<LinearModel>,
    /// Sizes of tolerances.
    pub sizes: VarianceComponents,
    /// What the readings say.
    pub posterior: Posterior,
    /// Where each number of each chosen hypothesis is among the unknowns.
    pub parameter_index: Vec<Vec<usize>>,
    /// Numbers of each case.
    pub thetas: Vec<Parameters>,
    /// Equilibrium of each case.
    pub states: Vec<State>,
    /// Contacts that remember.
    pub memories: Vec<HysteresisState>,
}

impl FittedModel {
    /// Turned residual (reading minus prediction) where the linear model ends, and Jacobian, whitened at the fit's sizes. What a fit
    /// stopped short of its minimum by would look like structure along directions that it absorbs.
    pub fn whitened(&self) -> (DVector<f64>, DMatrix<f64>) {
        self.whitened_at(&self.sizes, &self.posterior)
    }

    /// The same at other sizes of tolerances, with the posterior there.
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

    /// True for a stiffness or a number of a cause, false for a small error.
    pub fn is_of_the_model(&self, unknown: usize) -> bool {
        self.priors[unknown].group.is_none()
            || self
                .parameter_index
                .iter()
                .flatten()
                .any(|at| *at == unknown)
    }

    /// Logarithm of the prior odds of what is in it.
    pub fn ln_prior(&self) -> f64 {
        Hypothesis::ln_prior_of(&self.effects)
    }

    /// Logarithm of evidence and prior. What the linear model promises beyond where the fit could go does not count.
    pub fn ln_posterior(&self) -> f64 {
        self.posterior.ln_z - self.posterior.gain + self.ln_prior()
    }

    /// False for a fit that stopped early, far from the optimum of its linear model.
    pub fn is_converged(&self) -> bool {
        self.posterior.gain < SETTLED
    }

    /// Numbers of a chosen hypothesis.
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

    /// Whether the data contradict the sign a chosen hypothesis must have, by two standard errors. A further part of a law may not pull at
    /// all; a play below zero is none, but a link that yields.
    pub fn has_wrong_sign(&self, chosen: usize) -> bool {
        let hypothesis = &self.effects[chosen];
        let at = self.parameter_index[chosen][0];
        hypothesis.one_sided
            && !matches!(
                hypothesis.numbers[0].unknown,
                Parametrisation::Compliance(_)
            )
            && self.x[at]
                < match hypothesis.part {
                    0 if hypothesis.cause != Cause::FreePlay => {
                        -2.0 * self.posterior.covariance[(at, at)].max(0.0).sqrt()
                    }
                    _ => 0.0,
                }
    }

    /// Estimate and standard error of stiffness `k` of the study, in units of the deck.
    pub fn stiffness(&self, k: usize) -> (f64, f64) {
        let value = libm::exp(self.x[k]);
        (
            value,
            value * self.posterior.covariance[(k, k)].max(0.0).sqrt(),
        )
    }

    /// What one cause does to each row, further parts of its law included: the prediction less that without it, stiffnesses, tolerances and
    /// all else being what they are. `None` where a case has no equilibrium without it.
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

    /// What solves all cases of its deck, from where they are.
    fn predictor<'p>(&'p self, problem: &'p Problem<'p>) -> Option<NativePredictor<'p>> {
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

    /// The same linear model on other rows, at the same sizes: unknowns and their covariance, without any new solution.
    pub fn relinearised_on(&self, whitening: &Whitening) -> Option<(DVector<f64>, Posterior)> {
        self.relinearised_with_offset(whitening, &DVector::zeros(self.residual.len()))
    }

    /// The same with predictions that are off by so much in each row.
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

    /// The Jacobian of turned rows, made anew: searches keep many fits.
    pub fn whitened_jacobian(&self) -> DMatrix<f64> {
        self.whitening.apply(&self.jacobian)
    }

    /// Turned rows of reading minus prediction.
    pub fn whitened_residual(&self) -> DVector<f64> {
        self.whitening.apply_vector(&-&self.residual)
    }

    /// The evidence of the same linear model without some rows, whose marks of one part and case go together, and what it leaves of
    /// all. Jacobian and residual are those of turned rows.
    pub fn evidence_without(
        &self,
        rows: (&DMatrix<f64>, &DVector<f64>),
        left_out: &[bool],
    ) -> Option<(DVector<f64>, f64)> {
        let linear = self.linear.without(&self.whitening, rows, left_out);
        let reached = linear.solve(&self.sizes, 0.0)?;
        let misfit = &self.residual + &self.jacobian * &reached.step;
        Some((misfit, reached.ln_z))
    }
}

/// Fits the deck extended by some hypotheses; `guesses` of their numbers are in units of their priors. What `warm` knows better is
/// taken from there. `None` where the extended deck cannot be compiled or solved.
pub(super) fn fit(
    subject: &DiagnosisProblem<'_>,
    chosen: &[(Hypothesis, Vec<f64>)],
    warm: Option<(&FittedModel, &[f64])>,
    data: Data,
) -> Option<FittedModel> {
    match fit_with_early_stopping(subject, chosen, warm, None, data, EarlyStopping::NONE)? {
        FitOutcome::New(fitted) => Some(Arc::unwrap_or_clone(fitted)),
        FitOutcome::Duplicate => None,
    }
}

/// What a fit is for.
#[derive(Clone, Copy)]
pub(super) struct EarlyStopping<'a> {
    /// Evidence in nats, prior left out, of the model that leads: a fit that will not come near stops where it is.
    pub lead: f64,
    /// A fit of the same causes and laws, wherever their numbers begin: one that leads to its end stops.
    pub known: Option<&'a FittedModel>,
    /// Evidence in nats, prior left out: a fit that begins below goes no further.
    pub least: f64,
}

impl<'a> EarlyStopping<'a> {
    /// No other model is known.
    pub(super) const NONE: Self = Self {
        lead: f64::NEG_INFINITY,
        known: None,
        least: f64::NEG_INFINITY,
    };

    /// Another fit of the same causes, or a better one of others.
    pub(super) fn beyond(known: &'a FittedModel) -> Self {
        Self {
            lead: known.ln_posterior() - known.ln_prior(),
            known: Some(known),
            ..Self::NONE
        }
    }

    /// The same; a fit that begins below so much evidence goes no further.
    pub(super) const fn above(self, least: f64) -> Self {
        Self { least, ..self }
    }

    /// True for a fit that stopped because it will not come near, or would have.
    pub(super) fn is_beaten(&self, fitted: &FittedModel) -> bool {
        let aim = Aim {
            lead: self.lead,
            ..Aim::NONE
        };
        aim.is_beaten(fitted.posterior.ln_z, fitted.posterior.gain)
    }

    /// True for a fit that went no further because it began astray.
    pub(super) fn is_astray(&self, fitted: &FittedModel) -> bool {
        fitted.posterior.ln_z - fitted.posterior.gain < self.least
    }

    fn aim(&self, chosen: &[(Hypothesis, Vec<f64>)]) -> Aim<'a> {
        let alike = |(a, (b, _)): (&Hypothesis, &(Hypothesis, Vec<f64>))| a.same_law(b);
        let same = |known: &&FittedModel| {
            known.is_converged()
                && known.effects.len() == chosen.len()
                && known.effects.iter().zip(chosen).all(alike)
        };
        Aim {
            lead: self.lead,
            known: self.known.filter(same).map(|known| known.x.as_slice()),
            least: self.least,
        }
    }
}

/// How a fit ended.
#[derive(Clone)]
pub(super) enum FitOutcome {
    /// Where no other did.
    New(Arc<FittedModel>),
    /// Where the known one of its target ended.
    Duplicate,
}

/// The same for a target, the sizes of tolerances from `sizes` if not from `warm`.
pub(super) fn fit_with_early_stopping(
    subject: &DiagnosisProblem<'_>,
    chosen: &[(Hypothesis, Vec<f64>)],
    warm: Option<(&FittedModel, &[f64])>,
    sizes: Option<&VarianceComponents>,
    data: Data,
    target: EarlyStopping<'_>,
) -> Option<FitOutcome> {
    let chosen = &apart(chosen)[..];
    let parent = warm.filter(|warm| sizes.is_none() && is_submodel_start(*warm, chosen));
    let own = || warm.map_or(&subject.sizes, |(fitted, _)| &fitted.sizes);
    let sizes = sizes.unwrap_or_else(own);
    let aim = target.aim(chosen);
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
    let unknowns = Unknowns::new((subject, &problem), &deck.prepared, chosen, known)?;
    let cases: Vec<usize> = (0..problem.measurement.cases.len()).collect();
    let whitening = subject.whitening(data);
    // Each has its own predictor: equilibria are followed from one solution to the next.
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
        // What a further cause takes up is left to it at first. Of the same causes sizes are known.
        let is_again = parent.is_some_and(|(parent, _)| parent.effects.len() == chosen.len());
        let first = if is_again {
            sizes.clone()
        } else {
            sizes.at(sizes.shrunk_to_median(1.0))
        };
        let start = sweep.beside(x, (&warm.jacobian, warm.unknowns.len()));
        let is_free = parent.is_some();
        let end = start.and_then(|start| sweep.settle(start, &first, (STEPS, aim), is_free));
        subject.count_sweeps(sweep.predictor.sweeps());
        (sweep, end)
    } else {
        // Stiffnesses that were fitted as if all else were exact can be so wrong that nothing leads away from them; everything at once
        // from afar goes astray as often, in other studies. The evidence says which of both ends is the better one. Where stiffnesses alone
        // nearly explain the readings there is nothing to run off after.
        let from = |alone: bool, aim: Aim<'_>| {
            let (mut sweep, mut x) = (begun()?, x.clone());
            if alone {
                sweep.stiffnesses_alone(&mut x);
            }
            let steps = if alone { STEPS } else { 2 * STEPS };
            let start = sweep.at(x);
            let missed = start.as_ref().is_none_or(|start| {
                let residual = &start.residual;
                residual.norm_squared() > MISSED * MISSED * residual.len() as f64
            });
            let end = start.and_then(|start| sweep.settle(start, sizes, (steps, aim), alone));
            subject.count_sweeps(sweep.predictor.sweeps());
            Some((sweep, end, missed))
        };
        let (sweep, first, missed) = from(true, aim)?;
        let known = first.as_ref().and_then(End::own);
        let to_beat = known.map_or(f64::NEG_INFINITY, Settled::reached);
        let aim = Aim {
            lead: to_beat,
            known: known.map(|known| known.point.x.as_slice()),
            ..Aim::NONE
        };
        let better = |(_, end, _): &(Sweep<'_>, Option<End>, bool)| {
            let own = end.as_ref().and_then(End::own);
            own.is_some_and(|own| own.reached() > to_beat)
        };
        let second = missed.then(|| from(false, aim)).flatten().filter(better);
        match second {
            Some((sweep, end, _)) => (sweep, end),
            None => (sweep, first),
        }
    };
    let settled = match end? {
        End::Own(settled) => *settled,
        End::Known => return Some(FitOutcome::Duplicate),
    };
    let (mut thetas, mut states) = (Vec::new(), Vec::new());
    for case in cases {
        let (state, theta) = sweep.predictor.answer(case)?;
        states.push(state.clone());
        thetas.push(theta.clone());
    }
    let (x, misfit, jacobian, linear) = settled.point.into_parts();
    Some(FitOutcome::New(Arc::new(FittedModel {
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
    })))
}

/// True for a fit of these causes, and perhaps others, and unknowns as it left them.
fn is_submodel_start(
    (fitted, x): (&FittedModel, &[f64]),
    chosen: &[(Hypothesis, Vec<f64>)],
) -> bool {
    let is_held =
        |(h, _): &(Hypothesis, Vec<f64>)| fitted.effects.iter().any(|own| own.same_form(h));
    fitted.is_converged() && fitted.x == x && chosen.iter().all(is_held)
}

/// Causes and the further parts that come in with them, each for itself.
fn apart(chosen: &[(Hypothesis, Vec<f64>)]) -> Vec<(Hypothesis, Vec<f64>)> {
    let each = |(h, guesses): &(Hypothesis, Vec<f64>)| {
        let mut left = guesses.as_slice();
        let own = |h: Hypothesis| {
            let (own, rest) = left.split_at(h.numbers.len());
            left = rest;
            (h, own.to_vec())
        };
        h.split().into_iter().map(own).collect::<Vec<_>>()
    };
    chosen.iter().flat_map(each).collect()
}

/// A model as it is written for others: causes and stiffnesses, small errors of everything else left out.
#[derive(Clone, Debug)]
pub struct DeckOnlyPrediction {
    /// Numbers of each case.
    pub thetas: Vec<Parameters>,
    /// Equilibrium of each case.
    pub states: Vec<State>,
}

impl DeckOnlyPrediction {
    /// Of a fit; `None` where a case cannot be solved.
    pub fn new(subject: &DiagnosisProblem<'_>, fitted: &FittedModel) -> Option<Self> {
        let deck = &fitted.deck;
        let problem = Problem {
            dataset: &deck.dataset,
            model: &deck.model,
            ..subject.problem.clone()
        };
        let mut predictor = fitted.predictor(&problem)?;
        let parameters = deck.prepared.system.parameters();
        let mut x = fitted.x[..fitted.unknowns.len()].to_vec();
        for (k, x) in x.iter_mut().enumerate() {
            if !fitted.is_of_the_model(k) {
                *x = 0.0;
            }
        }
        let numbers = fitted.unknowns.numbers(&parameters, &x);
        predictor.predict(&numbers, None);
        subject.count_sweeps(1);
        let held = problem.free.held_weights(&deck.prepared.system);
        let (mut thetas, mut states) = (Vec::new(), Vec::new());
        for case in 0..fitted.states.len() {
            let (state, theta) = predictor.answer(case)?;
            let mut theta = theta.clone();
            for weight in &held {
                weight.release(&mut theta, &numbers.theta);
            }
            states.push(state.clone());
            thetas.push(theta);
        }
        Some(Self { thetas, states })
    }
}

/// The model of a fit on other data or with other weights, from where it ended.
pub(super) fn refit(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
    data: Data,
) -> Option<FittedModel> {
    let from = Some((fitted, fitted.x.as_slice()));
    fit(subject, &with_zero_guesses(fitted), from, data)
}

/// What is in a fit, with guesses that its own values replace.
pub fn with_zero_guesses(fitted: &FittedModel) -> Vec<(Hypothesis, Vec<f64>)> {
    let zeros = |h: &Hypothesis| (h.clone(), vec![0.0; h.numbers.len()]);
    fitted.effects.iter().map(zeros).collect()
}
