use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::hypothesis::{Change, Column, Hypothesis, Turn, Unknown};
use super::subject::{Data, Subject};
use crate::identify::Problem;
use crate::identify::global::gauss_newton::{
    Ending, LeastSquares, Minimum, Prior, Tolerances, minimise,
};
use crate::identify::global::{
    Component, Direction, Evaluation, FitUnknown, FitUnknowns, Meaning, NativePredictor,
    NuisanceLayout, Observations, Predictor, Prepared, fit_unknowns,
};
use crate::mechanics::{Mat3, Vec3, exp, psi_theta_phi};
use crate::model::Model;
use crate::syntax::{Address, Dataset};
use crate::system::{Parameters, Slot, State};

/// The deck with some hypotheses in it, fitted jointly with stiffnesses and nuisances.
#[derive(Debug)]
pub struct Fitted {
    /// The deck, extended, its numbers as they were.
    pub dataset: Dataset,
    /// The same, compiled.
    pub prepared: Prepared,
    /// What is in it.
    pub chosen: Vec<Hypothesis>,
    /// Unknowns of the deck, the study's own first.
    pub unknowns: FitUnknowns,
    /// Unknowns of the measurement.
    pub layout: NuisanceLayout,
    /// The minimum; residuals and Jacobian are those of all rows.
    pub minimum: Minimum,
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

/// Fits the deck extended by some hypotheses. `starts` are the first guesses of their numbers in units of their prior; what `warm`
/// knows better is taken from there. `None` where the extended deck cannot be compiled or solved.
pub fn fit(
    subject: &Subject<'_>,
    chosen: &[(Hypothesis, Vec<f64>)],
    warm: Option<&Fitted>,
    data: Data,
) -> Option<Fitted> {
    let (dataset, model) = extend(subject.problem.dataset, chosen.iter().map(|(h, _)| h))?;
    let problem = Problem {
        dataset: &dataset,
        model: &model,
        ..subject.problem.clone()
    };
    let prepared = Prepared::new(&problem).ok()?;
    let mut setup = Setup::new((subject, &problem), &prepared, chosen, warm)?;
    let cases: Vec<usize> = (0..problem.measurement.cases.len()).collect();
    let weights = subject.weights(data);
    let (mut found, mut sweeps) = (None, 0);
    let rounds = if setup.slips() { 3 } else { 1 };
    for _ in 0..rounds {
        let observations = Observations::new(problem.measurement, &model, &cases);
        let predictor = prepared
            .native(&problem, observations.observed.clone())
            .ok()?;
        let mut least_squares = FitProblem {
            setup: &setup,
            observations,
            predictor,
            weights: weights.clone(),
        };
        let tolerances = Tolerances {
            decrement: 1e-3,
            step: 1e-7,
            max_iterations: 40,
        };
        let held = vec![false; setup.start.len()];
        let start = setup.start.clone();
        let minimum = minimise(
            &mut least_squares,
            &start,
            &setup.priors,
            &setup.scale,
            &held,
            tolerances,
        )?;
        if minimum.ending == Ending::NoAnswer {
            return None;
        }
        // A rejected step may have been the last that was solved.
        least_squares.evaluate(&minimum.x, false)?;
        let mut thetas = Vec::with_capacity(cases.len());
        let mut states = Vec::with_capacity(cases.len());
        for case in &cases {
            let (state, theta) = least_squares.predictor.answer(*case)?;
            states.push(state.clone());
            thetas.push(theta.clone());
        }
        sweeps += least_squares.predictor.sweeps();
        setup.start.clone_from(&minimum.x);
        setup.update_slips(&model, (&thetas, &states));
        found = Some((minimum, thetas, states));
    }
    let (minimum, thetas, states) = found?;
    Some(Fitted {
        chosen: chosen.iter().map(|(h, _)| h.clone()).collect(),
        unknowns: setup.unknowns,
        layout: setup.layout,
        places: setup.places,
        priors: setup.priors,
        minimum,
        weights,
        thetas,
        states,
        sweeps,
        dataset,
        prepared,
    })
}

/// The deck with the statements of these hypotheses.
fn extend<'h>(
    dataset: &Dataset,
    chosen: impl Iterator<Item = &'h Hypothesis>,
) -> Option<(Dataset, Model)> {
    let mut dataset = dataset.clone();
    for change in chosen.flat_map(|hypothesis| &hypothesis.changes) {
        let edits = match change {
            Change::Add(statement) => dataset.add(statement),
            Change::Text(address, text) => dataset.set_text(address, text).ok()?,
        };
        dataset = dataset.edited(&edits).ok()?.value;
    }
    let model = crate::model::lower(&dataset).value;
    Some((dataset, model))
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
    slips: Vec<(usize, super::hypothesis::Slip, f64)>,
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
        warm: Option<&Fitted>,
    ) -> Option<Self> {
        let system = &prepared.system;
        let mut list = fit_unknowns(problem, system, None).list().to_vec();
        list.retain(|unknown| match unknown.meaning {
            Meaning::Offset(component) => {
                let id = system.catalogue().info(component.stiffness).address.id;
                !subject.offsets_in_question.iter().any(|of| Some(*of) == id)
            }
            _ => true,
        });
        let own = list.len();
        let mut start: Vec<f64> = match warm {
            Some(warm) => warm.minimum.x[..own].to_vec(),
            None => list.iter().map(|unknown| unknown.start).collect(),
        };
        let slot = |address: &Address| system.catalogue().slot(address);
        let (mut rows, mut turns, mut slips) = (Vec::new(), Vec::new(), Vec::new());
        let (mut row_starts, mut places) = (Vec::new(), Vec::new());
        for (hypothesis, guesses) in chosen {
            let known = warm.and_then(|warm| {
                let at = warm.chosen.iter().position(|h| h.same(hypothesis))?;
                Some(
                    warm.places[at]
                        .iter()
                        .map(|k| warm.minimum.x[*k])
                        .collect::<Vec<_>>(),
                )
            });
            let mut place = Vec::new();
            for (k, number) in hypothesis.numbers.iter().enumerate() {
                let mut guess = known.as_ref().map_or(guesses[k], |known| known[k]);
                let (mut mean, mut sd) = (0.0, 1.0);
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
                        Meaning::Number(scaled(pairs)?)
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
                    (Unknown::Slip(slip), column) => {
                        let Column::Wrench(_, pattern) = column else {
                            return None;
                        };
                        let factor = slip.force.1 * number.sd;
                        slips.push((list.len(), slip.clone(), factor));
                        let pattern = pattern.iter().map(|w| w[slip.axis] * factor).collect();
                        Meaning::PerCase(vec![(slot(&slip.force.0)?, pattern)])
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
        match warm {
            Some(warm) => {
                let first = warm.unknowns.len();
                start.extend_from_slice(&warm.minimum.x[first..first + layout.sd.len()]);
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
            slips,
            places,
            start,
            priors,
            scale,
        })
    }

    fn slips(&self) -> bool {
        !self.slips.is_empty()
    }

    /// The slip states that belong to the displacements now found.
    fn update_slips(&mut self, model: &Model, (thetas, states): (&[Parameters], &[State])) {
        let mut list = self.unknowns.list().to_vec();
        for (at, slip, factor) in &self.slips {
            let u: Vec<f64> = thetas
                .iter()
                .zip(states)
                .map(|(theta, state)| {
                    super::survey::displacement(model, (theta, state), slip.pair, slip.axis)
                })
                .collect();
            if let Meaning::PerCase(slots) = &mut list[*at].meaning {
                slots[0].1 = slip.pattern(&u).into_iter().map(|p| p * factor).collect();
            }
        }
        self.unknowns = FitUnknowns::new(list);
    }
}

struct FitProblem<'a> {
    setup: &'a Setup,
    observations: Observations<'a>,
    predictor: NativePredictor<'a>,
    weights: DVector<f64>,
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
                let R: Mat3 = theta.marker(*marker).R * exp(&(axis * (x[*at] * sd)));
                let angles = psi_theta_phi(&R);
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
        Some(out)
    }

    fn weights(&self, _residual: &DVector<f64>) -> DVector<f64> {
        self.weights.clone()
    }
}
