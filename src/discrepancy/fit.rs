//! The deck with some causes in it, fitted jointly with stiffnesses, tolerances and their sizes.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::extended_deck::{ExtendedDeck, deck_of, like};
use super::hypothesis::{Hypothesis, Unknown};
use super::subject::{Data, Subject};
use super::unknowns::{Known, Unknowns};
use crate::identify::Problem;
use crate::identify::global::gauss_newton::{Ending, LeastSquares, Tolerances, minimise};
use crate::identify::global::{
    Evaluation, FitUnknowns, Memory, NativePredictor, NuisanceLayout, Observations, Predictor,
};
use crate::system::{Parameters, State};
use crate::tolerance::{self, Linear, Posterior, Sizes, Whitening};

/// The longest step of the logarithm of a stiffness, at first and later.
const REACH: [f64; 2] = [0.8, 1.2];
/// A step that promises less than so many nats was the last one.
const ENOUGH: f64 = 0.05;
/// Steps of a fit at most.
const STEPS: usize = 16;
/// Sizes of tolerances are held for so many steps of a fit that starts from another, unless a step promises less than so many nats.
const HELD: usize = 5;
const NEAR: f64 = 30.0;
/// A step that lowers the objective by less than this is a small one; after so many in a row a fit ends.
const LITTLE: f64 = 0.2;
const SLOW: usize = 3;
/// Steps that led uphill are damped so often: at first by so much, then by so many times more; what led down is damped less by so
/// many times, and below a limit no more.
const TRIALS: usize = 8;
const FIRST: f64 = 0.3;
const HARDER: f64 = 6.0;
const EASE: f64 = 6.0;
const EASED: f64 = 0.3;

/// A model linearised where its fit ended, and what the readings say there.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The deck; fits of the same structure share it.
    pub deck: Arc<ExtendedDeck>,
    /// What is in it.
    pub chosen: Vec<Hypothesis>,
    /// Unknowns of the deck: stiffnesses, members of the tolerance layer, numbers of causes.
    pub unknowns: FitUnknowns,
    /// Unknowns of the measurement.
    pub layout: NuisanceLayout,
    /// Values of all unknowns.
    pub x: Vec<f64>,
    /// Priors of all unknowns.
    pub priors: Vec<tolerance::Unknown>,
    /// Prediction minus reading of all rows in units of the declared noise.
    pub misfit: DVector<f64>,
    /// Its derivative by all unknowns.
    pub jacobian: DMatrix<f64>,
    /// What turned the rows.
    pub whitening: Arc<Whitening>,
    /// The Jacobian of turned rows.
    pub turned: DMatrix<f64>,
    /// The linear model.
    pub linear: Arc<Linear>,
    /// Sizes of tolerances.
    pub sizes: Sizes,
    /// What the readings say.
    pub posterior: Posterior,
    /// Where each number of each chosen hypothesis is among the unknowns.
    pub places: Vec<Vec<usize>>,
    /// Numbers of each case.
    pub thetas: Vec<Parameters>,
    /// Equilibrium of each case.
    pub states: Vec<State>,
    /// Contacts that remember.
    pub memories: Vec<Memory>,
}

/// A number's estimate and its standard error in the units of `diagnosis.json`.
#[derive(Clone, PartialEq, Debug)]
pub struct Estimate {
    /// Its name.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Standard error.
    pub std_error: f64,
}

impl Fitted {
    /// Turned residual (reading minus prediction) where the linear model ends, and Jacobian, whitened at the fit's sizes. What a fit
    /// stopped short of its minimum by would look like structure along directions that it absorbs.
    pub fn whitened(&self) -> (DVector<f64>, DMatrix<f64>) {
        let weights = self.whitening.weights(&self.sizes.ln);
        let end = &self.misfit + &self.jacobian * &self.posterior.step;
        let residual = self.whitening.apply_vector(&-end).component_mul(&weights);
        let mut jacobian = self.turned.clone();
        for (mut row, weight) in jacobian.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        (residual, jacobian)
    }

    /// True for a stiffness or a number of a cause, false for a small error.
    pub fn is_of_the_model(&self, unknown: usize) -> bool {
        self.priors[unknown].group.is_none()
            || self.places.iter().flatten().any(|at| *at == unknown)
    }

    /// Logarithm of the prior odds of what is in it.
    pub fn ln_prior(&self) -> f64 {
        self.chosen.iter().map(|h| h.ln_prior).sum()
    }

    /// Logarithm of evidence and prior. What the linear model promises beyond where the fit could go does not count.
    pub fn ln_posterior(&self) -> f64 {
        self.posterior.ln_z - self.posterior.gain + self.ln_prior()
    }

    /// Numbers of a chosen hypothesis.
    pub fn estimates(&self, chosen: usize) -> Vec<Estimate> {
        let hypothesis = &self.chosen[chosen];
        let covariance = &self.posterior.covariance;
        hypothesis
            .numbers
            .iter()
            .zip(&self.places[chosen])
            .map(|(number, &at)| {
                let (x, sd) = (self.x[at], covariance[(at, at)].max(0.0).sqrt());
                let (value, std_error) = match number.unknown {
                    Unknown::Compliance(_) => ((-x).exp(), (-x).exp() * sd),
                    Unknown::SlipLength { .. } => {
                        let first = self.places[chosen][0];
                        let force = self.x[first];
                        let scale = hypothesis.numbers[0].sd;
                        let stiffness = force * scale / x.exp();
                        // d ln(force / length) = d force / force - d ln length.
                        let relative = covariance[(first, first)] / (force * force)
                            + covariance[(at, at)]
                            - 2.0 * covariance[(first, at)] / force;
                        (stiffness, stiffness.abs() * relative.max(0.0).sqrt())
                    }
                    Unknown::Offset { .. } | Unknown::Member(_) => (x, sd),
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

    /// Whether the data contradict the sign a chosen hypothesis must have, by two standard errors.
    pub fn has_wrong_sign(&self, chosen: usize) -> bool {
        let hypothesis = &self.chosen[chosen];
        let at = self.places[chosen][0];
        hypothesis.one_sided
            && !matches!(hypothesis.numbers[0].unknown, Unknown::Compliance(_))
            && self.x[at] < -2.0 * self.posterior.covariance[(at, at)].max(0.0).sqrt()
    }

    /// Estimate and standard error of stiffness `k` of the study, in units of the deck.
    pub fn stiffness(&self, k: usize) -> (f64, f64) {
        let value = self.x[k].exp();
        (
            value,
            value * self.posterior.covariance[(k, k)].max(0.0).sqrt(),
        )
    }

    /// Prediction minus reading where the linear model would end with other sizes of tolerances.
    pub fn at_sizes(&self, sizes: &Sizes) -> DVector<f64> {
        match self.linear.posterior(sizes) {
            Some(posterior) => &self.misfit + &self.jacobian * &posterior.step,
            None => self.misfit.clone(),
        }
    }

    /// Prediction minus reading without what a chosen hypothesis does to first order, `stiffnesses` refitted and all else as it is.
    pub fn misfit_without(&self, chosen: usize, stiffnesses: usize) -> DVector<f64> {
        let mut effect = DVector::zeros(self.misfit.len());
        for at in &self.places[chosen] {
            effect.axpy(self.x[*at], &self.jacobian.column(*at), 1.0);
        }
        let weights = self.whitening.weights(&self.sizes.ln);
        let mut own = self.turned.columns(0, stiffnesses).into_owned();
        for (mut row, weight) in own.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        let target = self.whitening.apply_vector(&effect).component_mul(&weights);
        let information = own.tr_mul(&own) + DMatrix::identity(stiffnesses, stiffnesses);
        let taken = match nalgebra::Cholesky::new(information) {
            Some(factor) => factor.solve(&own.tr_mul(&target)),
            None => DVector::zeros(stiffnesses),
        };
        &self.misfit - effect + self.jacobian.columns(0, stiffnesses) * taken
    }

    /// The same linear model on other rows, at the same sizes: unknowns and their covariance, without any new solution.
    pub fn linearly(&self, whitening: &Whitening) -> Option<(DVector<f64>, Posterior)> {
        self.linearly_off(whitening, &DVector::zeros(self.misfit.len()))
    }

    /// The same with predictions that are off by so much in each row.
    pub fn linearly_off(
        &self,
        whitening: &Whitening,
        off: &DVector<f64>,
    ) -> Option<(DVector<f64>, Posterior)> {
        let misfit = &self.misfit + off;
        let linear = Linear::new(
            whitening,
            &whitening.apply(&self.jacobian),
            &whitening.apply_vector(&-&misfit),
            self.priors.clone(),
            DVector::from_column_slice(&self.x),
        );
        let posterior = linear.posterior(&self.sizes)?;
        let misfit = misfit + &self.jacobian * &posterior.step;
        Some((misfit, posterior))
    }
}

/// Fits the deck extended by some hypotheses; `guesses` of their numbers are in units of their priors. What `warm` knows better is
/// taken from there. A fit that promises less than `least` nats of evidence, prior left out, stops where it is. `None` where the
/// extended deck cannot be compiled or solved.
pub fn fit(
    subject: &Subject<'_>,
    chosen: &[(Hypothesis, Vec<f64>)],
    warm: Option<(&Fitted, &[f64])>,
    data: Data,
    least: f64,
) -> Option<Fitted> {
    let deck = deck_of(
        subject,
        chosen,
        warm.map(|(fitted, _)| (fitted.chosen.as_slice(), &fitted.deck)),
    )?;
    let problem = Problem {
        dataset: &deck.dataset,
        model: &deck.model,
        ..subject.problem.clone()
    };
    let known = warm.map(|(fitted, x)| Known {
        unknowns: &fitted.unknowns,
        chosen: &fitted.chosen,
        places: &fitted.places,
        x,
    });
    let unknowns = Unknowns::new((subject, &problem), &deck.prepared, chosen, known)?;
    let cases: Vec<usize> = (0..problem.measurement.cases.len()).collect();
    let observations = Observations::new(problem.measurement, &deck.model, &cases);
    let mut predictor = deck
        .prepared
        .native(&problem, observations.observed.clone())
        .ok()?
        .remembering(unknowns.memories.clone());
    if let Some((warm, _)) = warm {
        for (case, state) in warm.states.iter().enumerate() {
            let state = like(&deck, state, &warm.deck);
            predictor.start_from(case, state, unknowns.deck.clone());
        }
    }
    let whitening = Arc::new(subject.whitening(data));
    let mut sweep = Sweep {
        of_the_model: unknowns.of_the_model(),
        unknowns: &unknowns,
        observations,
        predictor,
        whitening: &whitening,
        stiffnesses: subject.problem.unknowns.len(),
    };
    let mut x = unknowns.start.clone();
    if warm.is_none() {
        sweep.stiffnesses_alone(&mut x);
    }
    let first = match warm {
        Some((warm, _)) => warm.sizes.at(warm.sizes.modest(1.0)),
        None => subject.sizes.clone(),
    };
    let start = match warm {
        Some((warm, _)) => sweep.beside(x, warm),
        None => sweep.at(x),
    };
    let mut settled = start.and_then(|start| {
        let alone = warm.is_none();
        sweep.settle(start, &first, (STEPS, least), alone)
    });
    // Stiffnesses that were fitted as if all else were exact can be so wrong that nothing leads away from them.
    if warm.is_none() && settled.as_ref().is_none_or(|s| s.posterior.gain > NEAR) {
        let again = sweep
            .at(unknowns.start.clone())
            .and_then(|start| sweep.settle(start, &first, (2 * STEPS, least), false));
        let reached = |s: &Option<Settled>| {
            s.as_ref()
                .map_or(f64::NEG_INFINITY, |s| s.posterior.ln_z - s.posterior.gain)
        };
        if reached(&again) > reached(&settled) {
            settled = again;
        }
    }
    subject.spend(sweep.predictor.sweeps());
    let settled = settled?;
    let (mut thetas, mut states) = (Vec::new(), Vec::new());
    for case in cases {
        let (state, theta) = sweep.predictor.answer(case)?;
        states.push(state.clone());
        thetas.push(theta.clone());
    }
    Some(Fitted {
        chosen: chosen.iter().map(|(h, _)| h.clone()).collect(),
        x: settled.point.x,
        turned: settled.point.turned,
        misfit: settled.point.evaluation.residual,
        jacobian: settled.point.evaluation.jacobian,
        linear: Arc::new(settled.point.linear),
        sizes: settled.sizes,
        posterior: settled.posterior,
        priors: unknowns.priors,
        unknowns: unknowns.list,
        layout: unknowns.layout,
        places: unknowns.places,
        memories: unknowns.memories,
        whitening,
        thetas,
        states,
        deck,
    })
}

/// A model as it is written for others: causes and stiffnesses, small errors of everything else left out.
#[derive(Clone, Debug)]
pub struct Plain {
    /// Numbers of each case.
    pub thetas: Vec<Parameters>,
    /// Equilibrium of each case.
    pub states: Vec<State>,
}

impl Plain {
    /// Of a fit; `None` where a case cannot be solved.
    pub fn new(subject: &Subject<'_>, fitted: &Fitted) -> Option<Self> {
        let deck = &fitted.deck;
        let problem = Problem {
            dataset: &deck.dataset,
            model: &deck.model,
            ..subject.problem.clone()
        };
        let cases: Vec<usize> = (0..problem.measurement.cases.len()).collect();
        let observations = Observations::new(problem.measurement, &deck.model, &cases);
        let mut predictor = deck
            .prepared
            .native(&problem, observations.observed)
            .ok()?
            .remembering(fitted.memories.clone());
        let parameters = deck.prepared.system.parameters();
        for (case, state) in fitted.states.iter().enumerate() {
            predictor.start_from(case, state.clone(), parameters.clone());
        }
        let mut x = fitted.x[..fitted.unknowns.len()].to_vec();
        for (k, x) in x.iter_mut().enumerate() {
            if !fitted.is_of_the_model(k) {
                *x = 0.0;
            }
        }
        predictor.predict(&fitted.unknowns.numbers(&parameters, &x), None);
        subject.spend(1);
        let (mut thetas, mut states) = (Vec::new(), Vec::new());
        for case in cases {
            let (state, theta) = predictor.answer(case)?;
            states.push(state.clone());
            thetas.push(theta.clone());
        }
        Some(Self { thetas, states })
    }
}

/// Of a fit that is to be carried to its end however poor it is.
pub const ANY: f64 = f64::NEG_INFINITY;

/// The model of a fit on other data or with other weights, from where it ended.
pub fn refit(subject: &Subject<'_>, fitted: &Fitted, data: Data) -> Option<Fitted> {
    fit(
        subject,
        &unguessed(fitted),
        Some((fitted, &fitted.x)),
        data,
        ANY,
    )
}

/// What is in a fit, with guesses that its own values replace.
pub fn unguessed(fitted: &Fitted) -> Vec<(Hypothesis, Vec<f64>)> {
    let chosen = fitted.chosen.iter();
    chosen
        .map(|h| (h.clone(), vec![0.0; h.numbers.len()]))
        .collect()
}

/// Residuals and derivatives at some values of the unknowns.
struct Point {
    x: Vec<f64>,
    evaluation: Evaluation,
    /// The Jacobian of turned rows.
    turned: DMatrix<f64>,
    linear: Linear,
    /// False where derivatives by small errors are those of a point nearby.
    is_exact: bool,
}

/// The end of a fit.
struct Settled {
    point: Point,
    sizes: Sizes,
    posterior: Posterior,
}

/// Residuals as a function of the unknowns.
struct Sweep<'a> {
    unknowns: &'a Unknowns,
    observations: Observations<'a>,
    predictor: NativePredictor<'a>,
    whitening: &'a Whitening,
    /// How many unknowns are stiffnesses; they come first.
    stiffnesses: usize,
    /// Unknowns of the deck that are no small errors, in ascending order.
    of_the_model: Vec<usize>,
}

impl Sweep<'_> {
    /// Everything at `x`.
    fn at(&mut self, x: Vec<f64>) -> Option<Point> {
        let all: Vec<usize> = (0..self.unknowns.list.len()).collect();
        let evaluation = self.evaluate(&x, &all)?;
        let turned = self.whitening.apply(&evaluation.jacobian);
        let linear = Linear::new(
            self.whitening,
            &turned,
            &self.whitening.apply_vector(&-&evaluation.residual),
            self.unknowns.priors.clone(),
            DVector::from_column_slice(&x),
        );
        Some(Point {
            x,
            evaluation,
            turned,
            linear,
            is_exact: true,
        })
    }

    /// At `x`, with the derivatives by small errors from another model that has them too: they differ little.
    fn beside(&mut self, x: Vec<f64>, warm: &Fitted) -> Option<Point> {
        let (count, theirs) = (self.unknowns.list.len(), warm.unknowns.len());
        let nuisances = self.unknowns.layout.sd.len();
        if warm.layout.sd.len() != nuisances {
            return self.at(x);
        }
        let mut evaluation = self.evaluate(&x, &self.of_the_model.clone())?;
        let errors = (0..count).filter(|k| self.of_the_model.binary_search(k).is_err());
        let from = errors.map(|k| (k, k));
        let from = from.chain((0..nuisances).map(|k| (count + k, theirs + k)));
        for (own, other) in from {
            let known = warm.jacobian.column(other);
            evaluation.jacobian.set_column(own, &known);
        }
        let turned = self.whitening.apply(&evaluation.jacobian);
        let linear = Linear::new(
            self.whitening,
            &turned,
            &self.whitening.apply_vector(&-&evaluation.residual),
            self.unknowns.priors.clone(),
            DVector::from_column_slice(&x),
        );
        Some(Point {
            x,
            evaluation,
            turned,
            linear,
            is_exact: false,
        })
    }

    /// At `x`, with the derivatives by small errors of a point nearby.
    fn near(&mut self, x: Vec<f64>, point: &Point) -> Option<Point> {
        let own = self.of_the_model.clone();
        let mut evaluation = self.evaluate(&x, &own)?;
        let changed = self
            .whitening
            .apply(&evaluation.jacobian.select_columns(&own));
        let (mut jacobian, mut turned) = (point.evaluation.jacobian.clone(), point.turned.clone());
        for (k, at) in own.iter().enumerate() {
            jacobian.set_column(*at, &evaluation.jacobian.column(*at));
            turned.set_column(*at, &changed.column(k));
        }
        evaluation.jacobian = jacobian;
        let linear = point.linear.moved(
            self.whitening,
            (
                &turned,
                &self.whitening.apply_vector(&-&evaluation.residual),
            ),
            &own,
            DVector::from_column_slice(&x),
        );
        Some(Point {
            x,
            evaluation,
            turned,
            linear,
            is_exact: false,
        })
    }

    /// Solves all cases; derivatives by these unknowns of the deck, in ascending order, and by all of the measurement.
    fn evaluate(&mut self, x: &[f64], columns: &[usize]) -> Option<Evaluation> {
        let own = &self.unknowns.list;
        let count = own.len();
        let numbers = own.numbers(&self.unknowns.deck, &x[..count]);
        let mut directions = own.directions(&numbers.theta, &x[..count]);
        let mut at = 0..;
        directions.retain(|_| at.next().is_some_and(|k| columns.binary_search(&k).is_ok()));
        let prediction = self.predictor.predict(&numbers, Some(&directions));
        let inner = count + self.unknowns.layout.sd.len();
        let mut out =
            self.observations
                .evaluate(&prediction, &self.unknowns.layout, &x[..inner], true)?;
        let rows = &self.unknowns.rows;
        out.jacobian = out.jacobian.resize_horizontally(inner + rows.len(), 0.0);
        // Derivatives stand side by side; each goes to its own column, the last one first.
        for (k, column) in columns.iter().enumerate().rev() {
            if *column != k {
                out.jacobian.swap_columns(k, *column);
            }
        }
        for (k, column) in rows.iter().enumerate() {
            for (row, value) in column {
                out.residual[*row] += value * x[inner + k];
                out.jacobian[(*row, inner + k)] = *value;
            }
        }
        Some(out)
    }

    /// Stiffnesses first, from the deck, as if all else were exact.
    fn stiffnesses_alone(&mut self, x: &mut [f64]) {
        let count = self.stiffnesses;
        if count == 0 {
            return;
        }
        let priors = &self.unknowns.priors[..count];
        let priors: Vec<_> = priors
            .iter()
            .map(|prior| crate::identify::global::gauss_newton::Prior {
                mean: prior.mean,
                sd: prior.sd,
            })
            .collect();
        let scale: Vec<f64> = priors.iter().map(|prior| prior.sd.min(1.0)).collect();
        let start = x[..count].to_vec();
        let tolerances = Tolerances {
            decrement: 0.1,
            step: 1e-3,
            max_iterations: 40,
        };
        let mut alone = Alone {
            sweep: self,
            rest: x.to_vec(),
        };
        let held = vec![false; count];
        let found = minimise(&mut alone, &start, &priors, &scale, &held, tolerances);
        if let Some(found) = found.filter(|found| found.ending != Ending::NoAnswer) {
            x[..count].copy_from_slice(&found.x);
        }
    }

    /// Gauss-Newton over everything, the sizes by their evidence: at every step where the stiffnesses `alone` were fitted before. Ends
    /// early where less than `least` nats are promised. On the way derivatives by small errors stay as they are; at the end, and
    /// where they lead nowhere, they are exact.
    fn settle(
        &mut self,
        start: Point,
        first: &Sizes,
        (steps, least): (usize, f64),
        alone: bool,
    ) -> Option<Settled> {
        let mut sizes = first.clone();
        let mut here = start;
        // Steps of stiffnesses are made in what the deflections are linear in.
        let mut list = self.unknowns.list.clone();
        list.set_shares(&self.predictor.shares(&list.springs()).unwrap_or_default());
        let count = list.len();
        let (mut slow, mut damping) = (0, 0.0);
        for step_number in 0.. {
            // Far from the answer the sizes would take up what is not fitted yet.
            let mut posterior = here.linear.posterior(&sizes)?;
            if alone || step_number >= HELD || posterior.gain < NEAR {
                sizes = here.linear.sized(&sizes);
                posterior = here.linear.posterior(&sizes)?;
            }
            let objective = here.linear.objective(&sizes);
            // What the linear model promises counts for the fit here.
            let hopeless = step_number >= HELD && posterior.ln_z < least;
            if posterior.gain < ENOUGH || step_number >= steps || slow == SLOW || hopeless {
                if here.is_exact || hopeless {
                    return Some(Settled {
                        point: here,
                        sizes,
                        posterior,
                    });
                }
                here = self.at(here.x)?;
                continue;
            }
            let reach = REACH[step_number.min(1)];
            let (low, high) = list.limits(&vec![1.0; count], reach);
            let mut next = None;
            for _ in 0..TRIALS {
                let damped = here.linear.damped(&sizes, damping)?;
                let limited: Vec<(usize, f64)> = (0..count)
                    .filter(|k| self.unknowns.is_logarithm(*k))
                    .map(|k| (k, damped.step[k].clamp(low[k], high[k])))
                    .filter(|(k, step)| *step != damped.step[*k])
                    .collect();
                let mut step = damped.step_with(&limited);
                for (k, (low, high)) in low.iter().zip(&high).enumerate() {
                    if self.unknowns.is_logarithm(k) {
                        step[k] = step[k].clamp(*low, *high);
                    }
                }
                let mut there = list.moved(&here.x, &step.rows(0, count).into_owned());
                let rest = here.x.iter().zip(step.iter()).skip(count);
                there.extend(rest.map(|(x, s)| x + s));
                if let Some(further) = self.near(there, &here) {
                    let value = further.linear.objective(&sizes);
                    if value <= objective + ENOUGH {
                        let small = objective - value < LITTLE;
                        slow = if small { slow + 1 } else { 0 };
                        next = Some(further);
                        damping = if damping < EASED { 0.0 } else { damping / EASE };
                        break;
                    }
                }
                damping = (damping * HARDER).max(FIRST);
            }
            if let Some(next) = next {
                here = next;
                continue;
            }
            // Where no step leads down the answers are those of the last trial; go back.
            let was_exact = here.is_exact;
            here = self.at(here.x)?;
            if was_exact {
                return Some(Settled {
                    point: here,
                    sizes,
                    posterior,
                });
            }
            damping = 0.0;
        }
        None
    }
}

/// Stiffnesses alone, the rest where it is.
struct Alone<'a, 'b> {
    sweep: &'a mut Sweep<'b>,
    rest: Vec<f64>,
}

impl LeastSquares for Alone<'_, '_> {
    fn evaluate(&mut self, x: &[f64], with_jacobian: bool) -> Option<Evaluation> {
        let mut all = self.rest.clone();
        all[..x.len()].copy_from_slice(x);
        let active = if with_jacobian { x.len() } else { 0 };
        let columns: Vec<usize> = (0..active).collect();
        let out = self.sweep.evaluate(&all, &columns)?;
        let jacobian = out.jacobian.columns(0, active).into_owned();
        Some(Evaluation {
            residual: self.sweep.whitening.apply_vector(&out.residual),
            jacobian: self.sweep.whitening.apply(&jacobian),
        })
    }

    fn moved(&self, x: &[f64], step: &DVector<f64>) -> Vec<f64> {
        self.sweep.unknowns.list.moved(x, step)
    }

    fn limits(&self, scale: &[f64], reach: f64) -> (Vec<f64>, Vec<f64>) {
        self.sweep.unknowns.list.limits(scale, reach)
    }
}
