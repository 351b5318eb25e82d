use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::background::Background;
use super::effort::Effort;
use super::fit_problem::FitProblem;
use super::hypothesis::{Change, Hypothesis, Unknown};
use super::setup::Setup;
use super::subject::{Data, Subject};
use crate::identify::Problem;
use crate::identify::global::gauss_newton::{
    Ending, LeastSquares, Minimum, Prior, Tolerances, minimise,
};
use crate::identify::global::{
    FitUnknowns, Memory, NuisanceLayout, Observations, Predictor, Prepared,
};
use crate::model::Model;
use crate::syntax::Dataset;
use crate::system::{Parameters, State};

/// A deck extended by some hypotheses, compiled.
#[derive(Debug)]
pub struct ExtendedDeck {
    /// The deck, its numbers as they were.
    pub dataset: Dataset,
    /// The same, lowered.
    pub model: Model,
    /// The same, compiled.
    pub prepared: Prepared,
}

/// The deck with some hypotheses in it, fitted jointly with stiffnesses and nuisances.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The deck; fits of the same structure share it.
    pub deck: Arc<ExtendedDeck>,
    /// What is in it.
    pub chosen: Vec<Hypothesis>,
    /// Unknowns of the deck, the study's own first.
    pub unknowns: FitUnknowns,
    /// Unknowns of the measurement.
    pub layout: NuisanceLayout,
    /// The minimum; residuals and Jacobian are those of all rows, whitened by the background.
    pub minimum: Minimum,
    /// Prediction minus reading of all rows in units of their noise.
    pub misfit: DVector<f64>,
    /// What whitened the rows.
    pub background: Option<Arc<Background>>,
    /// Weight of each row.
    pub weights: DVector<f64>,
    /// Numbers of each case.
    pub thetas: Vec<Parameters>,
    /// Equilibrium of each case.
    pub states: Vec<State>,
    /// Where each number of each chosen hypothesis is among the unknowns.
    pub places: Vec<Vec<usize>>,
    /// Priors of all unknowns.
    pub priors: Vec<Prior>,
    /// Contacts that remember.
    pub memories: Vec<Memory>,
    /// How often all cases were solved.
    pub sweeps: usize,
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
    /// Twice the objective: squares of residuals and of priors.
    pub fn chi_square(&self) -> f64 {
        2.0 * self.minimum.objective
    }

    /// Posterior covariance of all unknowns.
    pub fn covariance(&self) -> DMatrix<f64> {
        let held = vec![false; self.priors.len()];
        crate::identify::global::confidence::covariance(&self.minimum, &held)
    }

    /// Rows less the unknowns the data really determine.
    pub fn dof(&self, covariance: &DMatrix<f64>) -> f64 {
        let rows: f64 = self.weights.iter().sum();
        let free: f64 = self
            .priors
            .iter()
            .enumerate()
            .map(|(k, prior)| {
                if prior.sd.is_finite() && prior.sd > 0.0 {
                    1.0 - covariance[(k, k)] / (prior.sd * prior.sd)
                } else {
                    1.0
                }
            })
            .sum();
        (rows - free).max(1.0)
    }

    /// Numbers of a chosen hypothesis.
    pub fn estimates(&self, chosen: usize, covariance: &DMatrix<f64>) -> Vec<Estimate> {
        let hypothesis = &self.chosen[chosen];
        hypothesis
            .numbers
            .iter()
            .zip(&self.places[chosen])
            .map(|(number, &at)| {
                let (x, sd) = (self.minimum.x[at], covariance[(at, at)].max(0.0).sqrt());
                let (value, std_error) = match number.unknown {
                    Unknown::Compliance(_) => ((-x).exp(), (-x).exp() * sd),
                    Unknown::SlipLength { .. } => {
                        let first = self.places[chosen][0];
                        let force = self.minimum.x[first];
                        let scale = hypothesis.numbers[0].sd;
                        let stiffness = force * scale / x.exp();
                        // d ln(force / length) = d force / force - d ln length.
                        let relative = covariance[(first, first)] / (force * force)
                            + covariance[(at, at)]
                            - 2.0 * covariance[(first, at)] / force;
                        (stiffness, stiffness.abs() * relative.max(0.0).sqrt())
                    }
                    Unknown::Offset { .. } => (x, sd),
                    _ => (x * number.sd, sd * number.sd),
                };
                Estimate {
                    name: number.name.clone(),
                    value,
                    std_error,
                }
            })
            .collect()
    }

    /// Whether the data contradict the sign a chosen hypothesis must have.
    pub fn has_wrong_sign(&self, chosen: usize) -> bool {
        let hypothesis = &self.chosen[chosen];
        hypothesis.one_sided
            && !matches!(hypothesis.numbers[0].unknown, Unknown::Compliance(_))
            && self.minimum.x[self.places[chosen][0]] < 0.0
    }
}

/// Where a fit begins: at another fit, its unknowns moved by a step.
#[derive(Clone, Copy)]
pub struct Warm<'a> {
    /// The other fit.
    pub fitted: &'a Fitted,
    /// A step of its unknowns, or nothing.
    pub step: &'a [f64],
}

impl<'a> Warm<'a> {
    /// Where another fit ended.
    pub const fn at(fitted: &'a Fitted) -> Self {
        Self { fitted, step: &[] }
    }

    /// Its unknowns, moved.
    pub(super) fn x(&self) -> Vec<f64> {
        let mut x = self.fitted.minimum.x.clone();
        for ((x, step), prior) in x.iter_mut().zip(self.step).zip(&self.fitted.priors) {
            let most = prior.sd.min(1.0);
            *x += step.clamp(-most, most);
        }
        x
    }
}

/// Fits the deck extended by some hypotheses. `starts` are the first guesses of their numbers in units of their prior; what `warm`
/// knows better is taken from there. `None` where the extended deck cannot be compiled or solved.
pub fn fit(
    subject: &Subject<'_>,
    chosen: &[(Hypothesis, Vec<f64>)],
    warm: Option<Warm<'_>>,
    data: Data,
    effort: Effort,
) -> Option<Fitted> {
    let changes = || chosen.iter().flat_map(|(h, _)| &h.changes);
    let plans = || chosen.iter().filter_map(|(h, _)| h.memory.as_ref());
    let same = warm.map(|warm| warm.fitted).filter(|fitted| {
        let theirs = fitted.chosen.iter();
        changes().eq(theirs.clone().flat_map(|h| &h.changes))
            && plans().eq(theirs.filter_map(|h| h.memory.as_ref()))
    });
    let deck = if let Some(fitted) = same {
        Arc::clone(&fitted.deck)
    } else {
        let measures: Vec<String> = plans().map(|plan| plan.measure.clone()).collect();
        Arc::new(extend(&subject.problem, changes(), &measures)?)
    };
    let problem = Problem {
        dataset: &deck.dataset,
        model: &deck.model,
        ..subject.problem.clone()
    };
    let setup = Setup::new((subject, &problem), &deck.prepared, chosen, warm)?;
    let cases: Vec<usize> = (0..problem.measurement.cases.len()).collect();
    let weights = subject.weights(data);
    let observations = Observations::new(problem.measurement, &deck.model, &cases);
    let mut predictor = deck
        .prepared
        .native(&problem, observations.observed.clone())
        .ok()?
        .remembering(setup.memories.clone());
    if let Some(warm) = warm {
        for (case, state) in warm.fitted.states.iter().enumerate() {
            let state = like(&deck, state, &warm.fitted.deck);
            predictor.start_from(case, state, setup.deck.clone());
        }
    }
    let mut least_squares = FitProblem {
        setup: &setup,
        observations,
        predictor,
        weights: weights.clone(),
        background: subject.background(data),
        misfit: DVector::zeros(0),
        last: Vec::new(),
        effort,
        objective: f64::INFINITY,
    };
    let tolerances = Tolerances {
        decrement: 1e-3,
        step: 1e-7,
        max_iterations: effort.steps,
    };
    let held = vec![false; setup.start.len()];
    let minimum = minimise(
        &mut least_squares,
        &setup.start,
        &setup.priors,
        &setup.scale,
        &held,
        tolerances,
    );
    subject.budget.spend(least_squares.predictor.sweeps());
    let minimum = minimum?;
    if minimum.ending == Ending::NoAnswer {
        return None;
    }
    // A rejected step may have been the last that was solved.
    if least_squares.last != minimum.x {
        least_squares.evaluate(&minimum.x, false)?;
    }
    let mut thetas = Vec::with_capacity(cases.len());
    let mut states = Vec::with_capacity(cases.len());
    for case in &cases {
        let (state, theta) = least_squares.predictor.answer(*case)?;
        states.push(state.clone());
        thetas.push(theta.clone());
    }
    let sweeps = least_squares.predictor.sweeps();
    let (misfit, background) = (least_squares.misfit, least_squares.background);
    Some(Fitted {
        chosen: chosen.iter().map(|(h, _)| h.clone()).collect(),
        unknowns: setup.unknowns,
        layout: setup.layout,
        places: setup.places,
        priors: setup.priors,
        memories: setup.memories,
        minimum,
        misfit,
        background,
        weights,
        thetas,
        states,
        sweeps,
        deck,
    })
}

/// The deck with the statements of some hypotheses, and channels for what they have to measure.
fn extend<'h>(
    problem: &Problem<'_>,
    changes: impl Iterator<Item = &'h Change>,
    measures: &[String],
) -> Option<ExtendedDeck> {
    let mut dataset = problem.dataset.clone();
    for change in changes {
        let edits = match change {
            Change::Add(statement) => dataset.add(statement),
            Change::Text(address, text) => dataset.set_text(address, text).ok()?,
        };
        dataset = dataset.edited(&edits).ok()?.value;
    }
    let model = crate::model::lower(&dataset).value;
    let extended = Problem {
        dataset: &dataset,
        model: &model,
        ..problem.clone()
    };
    let prepared = Prepared::with(&extended, measures).ok()?;
    Some(ExtendedDeck {
        dataset,
        model,
        prepared,
    })
}

/// A state of one deck as a first guess for another that has the same parts and joints and perhaps some more parts, which are pieces
/// of old ones and go with them.
fn like(deck: &ExtendedDeck, state: &State, theirs: &ExtendedDeck) -> State {
    if std::ptr::eq(deck, theirs) {
        return state.clone();
    }
    let mut new = deck.prepared.system.state();
    if new.multipliers.len() != state.multipliers.len() {
        return new;
    }
    for (k, pose) in new.poses.iter_mut().enumerate() {
        let header = &deck.model.parts[k].header;
        let whole = |other: &crate::model::Part| other.pose == deck.model.parts[k].pose;
        let parts = &theirs.model.parts;
        let at = parts
            .iter()
            .position(|other| other.header.id == header.id)
            .or_else(|| parts.iter().position(whole));
        if let Some(at) = at {
            *pose = state.poses[at];
        }
    }
    new.multipliers.clone_from(&state.multipliers);
    new.redundant.clone_from(&state.redundant);
    new
}
