use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::background::Background;
use super::hypothesis::{Change, Column, Hypothesis, Turn, Unknown};
use super::subject::{Data, Subject};
use crate::identify::Problem;
use crate::identify::global::gauss_newton::{
    Ending, LeastSquares, Minimum, Prior, Tolerances, minimise,
};
use crate::identify::global::{
    Component, Direction, Evaluation, FitUnknown, FitUnknowns, Meaning, Memory, NativePredictor,
    NuisanceLayout, Observations, Predictor, Prepared, fit_unknowns,
};
use crate::mechanics::{Mat3, Vec3, exp, psi_theta_phi};
use crate::model::Model;
use crate::syntax::{Address, Dataset};
use crate::system::{Parameters, Slot, State};

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
    fn x(&self) -> Vec<f64> {
        let mut x = self.fitted.minimum.x.clone();
        for ((x, step), prior) in x.iter_mut().zip(self.step).zip(&self.fitted.priors) {
            let most = prior.sd.min(1.0);
            *x += step.clamp(-most, most);
        }
        x
    }
}

/// Turns below this, in units of their prior, count as this.
const LEAST_TURN: f64 = 1e-7;
/// How much a fit may cost.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Effort {
    /// Steps tried at most.
    pub steps: usize,
    /// A step that gains less than this part of chi-square was the last one.
    pub relative: f64,
    /// An objective that is known to be reached otherwise: a fit that stays far above it and no longer comes down fast is given up.
    pub reached: f64,
}

impl Effort {
    /// For a model that is to be kept.
    pub const FULL: Self = Self {
        steps: 30,
        relative: 1e-7,
        reached: f64::INFINITY,
    };

    /// For one of many candidates, of which most are dropped.
    pub const fn candidate(reached: f64) -> Self {
        Self {
            steps: 14,
            relative: 1e-4,
            reached,
        }
    }

    /// Whether a fit that has come down from one objective to another may stop.
    fn is_enough(self, step: usize, (before, after): (f64, f64)) -> bool {
        let gained = before - after;
        let hopeless = after > 2.0 * self.reached + 100.0 && gained < 0.3 * (after - self.reached);
        gained < self.relative * after || (step >= 4 && hopeless)
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
    )?;
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

/// Columns that act on rows directly.
type RowColumn = Vec<(usize, f64)>;

/// Unknowns of an extended fit: those of the deck, of the measurement, and those that only act on rows.
struct Setup {
    deck: Parameters,
    unknowns: FitUnknowns,
    layout: NuisanceLayout,
    rows: Vec<RowColumn>,
    turns: Vec<(usize, Turn, [[Slot; 3]; 2])>,
    memories: Vec<Memory>,
    places: Vec<Vec<usize>>,
    start: Vec<f64>,
    priors: Vec<Prior>,
    scale: Vec<f64>,
}

impl Setup {
    fn new(
        (subject, problem): (&Subject<'_>, &Problem<'_>),
        prepared: &Prepared,
        chosen: &[(Hypothesis, Vec<f64>)],
        warm: Option<Warm<'_>>,
    ) -> Option<Self> {
        let at_warm = warm.map(|warm| warm.x());
        let warm = warm.map(|warm| warm.fitted);
        let system = &prepared.system;
        let mut list = fit_unknowns(problem, system, None).list().to_vec();
        list.retain(|unknown| match unknown.meaning {
            Meaning::Offset(component) => {
                let id = system.catalogue().info(component.stiffness).address.id;
                !subject.offsets_in_question.iter().any(|of| Some(*of) == id)
            }
            _ => true,
        });
        // What another fit says of the same unknown, whatever else was in it.
        let same = |a: &FitUnknown, b: &FitUnknown| {
            a.addresses == b.addresses
                && std::mem::discriminant(&a.meaning) == std::mem::discriminant(&b.meaning)
        };
        let of_warm = |unknown: &FitUnknown| {
            let (warm, x) = warm.zip(at_warm.as_ref())?;
            let list = warm.unknowns.list();
            let at = list.iter().position(|other| same(other, unknown))?;
            Some(x[at])
        };
        let mut start: Vec<f64> = list
            .iter()
            .map(|unknown| of_warm(unknown).unwrap_or(unknown.start))
            .collect();
        let slot = |address: &Address| system.catalogue().slot(address);
        let (mut rows, mut turns, mut memories) = (Vec::new(), Vec::new(), Vec::new());
        let (mut row_starts, mut places) = (Vec::new(), Vec::new());
        for (hypothesis, guesses) in chosen {
            let known = warm.zip(at_warm.as_ref()).and_then(|(warm, x)| {
                let at = warm.chosen.iter().position(|h| h.same(hypothesis))?;
                Some(warm.places[at].iter().map(|k| x[*k]).collect::<Vec<_>>())
            });
            if let Some(plan) = &hypothesis.memory {
                memories.push(Memory {
                    anchor: slot(&plan.anchor)?,
                    length: slot(&plan.length)?,
                    channel: problem.measurement.channels.len() + memories.len(),
                });
            }
            let mut place = Vec::new();
            for (k, number) in hypothesis.numbers.iter().enumerate() {
                let (mut mean, mut sd) = (number.mean / number.sd, 1.0);
                let mut guess = known.as_ref().map_or(guesses[k] + mean, |known| known[k]);
                let scaled = |pairs: &[(Address, f64)]| {
                    let scale = |(address, factor): &(Address, f64)| {
                        Some((slot(address)?, factor * number.sd))
                    };
                    pairs.iter().map(scale).collect::<Option<Vec<_>>>()
                };
                let meaning = match (&number.unknown, &number.column) {
                    (Unknown::Linear, Column::Rows(column)) => {
                        let column = column.iter().map(|(at, v)| (*at, v * number.sd));
                        place.push(usize::MAX - rows.len());
                        rows.push(column.collect::<RowColumn>());
                        row_starts.push(guess);
                        continue;
                    }
                    (Unknown::Linear, Column::Always(pairs)) | (Unknown::Extended(pairs), _) => {
                        let scaled = scaled(pairs)?;
                        // What the study drives is set anew in every case; the error comes on top each time.
                        let driven = |address: &Address| {
                            let loads = &problem.programme.loads;
                            loads.iter().any(|load| load.target == *address)
                        };
                        if pairs.iter().any(|(address, _)| driven(address)) {
                            let cases = problem.programme.cases.len();
                            let every = |(slot, factor)| (slot, vec![factor; cases]);
                            Meaning::PerCase(scaled.into_iter().map(every).collect())
                        } else {
                            Meaning::Number(scaled)
                        }
                    }
                    (Unknown::Linear, Column::PerCase(pairs)) => {
                        let mut factors = Vec::new();
                        for (address, values) in pairs {
                            let values = values.iter().map(|v| v * number.sd).collect();
                            factors.push((slot(address)?, values));
                        }
                        Meaning::PerCase(factors)
                    }
                    // A wrench is no number of a deck.
                    (Unknown::Linear, Column::Wrench(..)) => return None,
                    (Unknown::Compliance(addresses), _) => {
                        let components = addresses
                            .iter()
                            .map(|address| {
                                Some(Component {
                                    stiffness: slot(address)?,
                                    preload: None,
                                })
                            })
                            .collect::<Option<Vec<_>>>()?;
                        if known.is_none() {
                            guess = -(guess.max(1e-3) * number.sd).ln();
                        }
                        (mean, sd) = (-number.sd.ln(), 2.0);
                        Meaning::Stiffness(components)
                    }
                    (Unknown::Turn(turn), _) => {
                        let of = |k: usize| {
                            let word = |i| {
                                super::hypothesis::number(
                                    "MARKER",
                                    turn.markers[k].1,
                                    "REULER",
                                    Some(i),
                                )
                            };
                            Some([slot(&word(1))?, slot(&word(2))?, slot(&word(3))?])
                        };
                        turns.push((list.len(), turn.clone(), [of(0)?, of(1)?]));
                        Meaning::Number(Vec::new())
                    }
                    (Unknown::Offset { stiffness, preload }, _) => {
                        let meaning = Meaning::Offset(Component {
                            stiffness: slot(stiffness)?,
                            preload: Some(slot(preload)?),
                        });
                        // It may have been a nuisance so far.
                        let unknown = FitUnknown {
                            addresses: vec![stiffness.clone()],
                            meaning,
                            start: 0.0,
                            mean: 0.0,
                            sd: number.sd,
                        };
                        place.push(list.len());
                        start.push(of_warm(&unknown).unwrap_or(guess * number.sd));
                        list.push(unknown);
                        continue;
                    }
                    (
                        Unknown::SlipLength {
                            address,
                            start,
                            usual,
                        },
                        _,
                    ) => {
                        if known.is_none() {
                            guess = start.ln();
                        }
                        (mean, sd) = (usual.ln(), number.sd);
                        Meaning::Stiffness(vec![Component {
                            stiffness: slot(address)?,
                            preload: None,
                        }])
                    }
                };
                place.push(list.len());
                start.push(guess);
                list.push(FitUnknown {
                    addresses: Vec::new(),
                    meaning,
                    start: guess,
                    mean,
                    sd,
                });
            }
            places.push(place);
        }
        let unknowns = FitUnknowns::new(list);
        let frame = problem.settings.frame_sd;
        let frame = (frame.length, frame.angle_deg.to_radians());
        let layout = NuisanceLayout::new(problem.measurement, unknowns.len(), frame);
        match warm.zip(at_warm.as_ref()) {
            Some((warm, x)) => {
                let first = warm.unknowns.len();
                start.extend_from_slice(&x[first..first + layout.sd.len()]);
            }
            None => start.resize(unknowns.len() + layout.sd.len(), 0.0),
        }
        let first_row = start.len();
        for at in places
            .iter_mut()
            .flatten()
            .filter(|at| **at > usize::MAX / 2)
        {
            *at = first_row + (usize::MAX - *at);
        }
        start.extend(row_starts);
        let prior = |mean, sd| Prior { mean, sd };
        let mut priors: Vec<Prior> = unknowns
            .list()
            .iter()
            .map(|u| prior(u.mean, u.sd))
            .collect();
        priors.extend(layout.sd.iter().map(|sd| prior(0.0, *sd)));
        priors.extend(rows.iter().map(|_| prior(0.0, 1.0)));
        let scale = priors.iter().map(|p| p.sd.min(1.0)).collect();
        Some(Self {
            deck: system.parameters(),
            unknowns,
            layout,
            rows,
            turns,
            memories,
            places,
            start,
            priors,
            scale,
        })
    }
}

struct FitProblem<'a> {
    setup: &'a Setup,
    observations: Observations<'a>,
    predictor: NativePredictor<'a>,
    weights: DVector<f64>,
    background: Option<Arc<Background>>,
    /// Residuals of the last evaluation before they were whitened.
    misfit: DVector<f64>,
    /// The unknowns the predictor was asked for last.
    last: Vec<f64>,
    effort: Effort,
    /// After the last accepted step.
    objective: f64,
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

    fn progress(&mut self, iteration: usize, _x: &[f64], objective: f64) -> bool {
        let before = std::mem::replace(&mut self.objective, objective);
        !self.effort.is_enough(iteration, (before, objective))
    }
}
