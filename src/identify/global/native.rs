//! The built-in solver as a predictor: each case starts from its own last answer, moved along the tangent.

use super::channel::channel_changes;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use nalgebra::DMatrix;

use super::free::{STEPS, step};
use super::memory::{Carried, HysteresisState};
use super::predictor::{CaseChanges, CasePrediction, Observed, Prediction, Predictor};
use super::unknown::{Component, Direction, Numbers};
use admire_session::backend::{CaseSweeper, FreeMotions, HeldWeight, Loads};
use admire_solver::model::PartIx;
use admire_solver::statics::{Balance, Settings, Tangent, displace, twist};
use admire_solver::system::{Parameters, Scratch, Slot, State, System};
use admire_study::Channels;

/// What the last answer of one case was found at, and how it moves with theta.
#[derive(Clone, Debug)]
struct Answer {
    theta: Parameters,
    /// The unknowns of the fit.
    x: Vec<f64>,
    /// Some of those, and the change of the unknowns of the system by each, one column for each.
    response: (Vec<usize>, DMatrix<f64>),
}

/// The answers of all cases at some time.
#[derive(Clone, Debug, Default)]
struct Kept {
    states: Vec<Option<State>>,
    answers: Vec<Option<Arc<Answer>>>,
}

/// Predicts with the built-in solver.
#[derive(Debug)]
pub struct NativePredictor<'a> {
    system: &'a System,
    sweeper: CaseSweeper,
    observed: Observed,
    channels: Channels,
    scratch: Scratch,
    /// Directions of one case.
    directions: Vec<Direction>,
    answers: Vec<Option<Arc<Answer>>>,
    kept: Kept,
    memories: Vec<HysteresisState>,
    /// Weights of parts that spin.
    weights: Vec<HeldWeight>,
    /// True if the deck has free motions.
    has_free_motions: bool,
    sweeps: usize,
    runs: usize,
}

impl<'a> NativePredictor<'a> {
    /// For a compiled deck, its loads and what is observed.
    pub(crate) fn new(
        system: &'a System,
        loads: Loads,
        observed: Observed,
        channels: Channels,
    ) -> Self {
        Self {
            scratch: Scratch::new(system),
            directions: Vec::new(),
            answers: vec![None; loads.cases.len()],
            kept: Kept::default(),
            memories: Vec::new(),
            weights: Vec::new(),
            has_free_motions: false,
            sweeper: CaseSweeper::new(system, loads, Settings::tight()),
            system,
            observed,
            channels,
            sweeps: 0,
            runs: 0,
        }
    }

    /// With contacts that remember; their channels are among those of [`Self::new`].
    #[must_use]
    pub fn remembering(mut self, memories: Vec<HysteresisState>) -> Self {
        self.memories = memories;
        self
    }

    /// With the free motions of the deck. The weight of a part that spins acts on the parts that carry it.
    #[must_use]
    pub(crate) fn with_free_motions(mut self, free: &FreeMotions) -> Self {
        self.weights = free.held_weights(self.system);
        self.has_free_motions = !free.is_empty();
        if self.has_free_motions {
            self.sweeper.solver().expect_free_motions();
        }
        self
    }

    /// With other values of the loads.
    #[must_use]
    pub fn with_cases(mut self, cases: Vec<Vec<f64>>) -> Self {
        self.answers = vec![None; cases.len()];
        self.sweeper.set_cases(cases);
        self
    }

    /// Lets the first solve of a case start from this state of the same system.
    pub fn start_from(&mut self, case: usize, state: State, theta: Parameters) {
        self.sweeper.keep(case, state);
        self.answers[case] = Some(Arc::new(Answer {
            theta,
            x: Vec::new(),
            response: Default::default(),
        }));
    }

    /// The last answer of a case with the numbers it was solved at.
    pub fn answer(&self, case: usize) -> Option<(&State, &Parameters)> {
        let answer = self.answers[case].as_ref()?;
        Some((self.sweeper.answer(case)?, &answer.theta))
    }

    /// Solves one case from its own last answer, moved along its tangent.
    fn solve(&mut self, case: usize, theta: &Parameters, x: &[f64]) -> Option<State> {
        self.runs += 1;
        let mut own = self.sweeper.answer(case).cloned();
        if let (Some(state), Some(answer)) = (&mut own, &self.answers[case])
            && let Some(correction) = predicted(answer, x)
        {
            self.system.advance(state, &correction);
        }
        self.sweeper.solve(self.system, theta, case, own).ok()
    }

    /// Moves an equilibrium along its free motions to the best fit of the marks of its case. Gives the free motions there, one column each,
    /// and the tangent if it was made.
    fn settle_free(
        &mut self,
        case: usize,
        theta: &Parameters,
        state: &mut State,
    ) -> (DMatrix<f64>, Option<Tangent>) {
        let (mut motions, mut last) = (Vec::new(), None);
        for taken in 0..=STEPS {
            // The factors of the last iteration are not those of the equilibrium, and may show no free motion.
            if !(self.has_free_motions || self.sweeper.solver().has_free_motions()) {
                break;
            }
            let Ok(tangent) = self.sweeper.solver().tangent(self.system, theta, state) else {
                break;
            };
            motions = tangent.free_motions(self.system);
            let marks = self.observed.marks.get(case).map_or(&[][..], Vec::as_slice);
            let observed = self.observed.parts.iter();
            let twist = |motion: &Vec<f64>, part: &PartIx| twist(self.system, state, *part, motion);
            let twists: Vec<Vec<_>> = motions
                .iter()
                .map(|motion| observed.clone().map(|part| twist(motion, part)).collect())
                .collect();
            let pose = |part: usize| state.poses[self.observed.parts[part].0];
            let amounts = step(marks, &pose, &twists).filter(|_| taken < STEPS);
            let Some(amounts) = amounts else {
                last = Some(tangent);
                break;
            };
            self.sweeper.solver().give_back(tangent);
            let mut moved = state.clone();
            for (motion, amount) in motions.iter().zip(&amounts) {
                displace(self.system, &mut moved, motion, *amount);
            }
            let Ok(found) = self.sweeper.solve(self.system, theta, case, Some(moved)) else {
                break;
            };
            *state = found;
        }
        let n = self.system.unknowns();
        let motions = DMatrix::from_iterator(n, motions.len(), motions.into_iter().flatten());
        (motions, last)
    }

    /// Changes of the unknowns of the system along each direction, one column each; by the tangent there if that is known.
    fn responses(
        &mut self,
        case: usize,
        theta: &Parameters,
        state: &State,
        (directions, tangent): (&[Direction], Option<Tangent>),
    ) -> Option<DMatrix<f64>> {
        let solver = self.sweeper.solver();
        let tangent = match tangent {
            Some(tangent) => tangent,
            None => solver.tangent(self.system, theta, state).ok()?,
        };
        let n = self.system.unknowns();
        let mut column = vec![0.0; n];
        let mut here = self.system.evaluate(theta, state, &mut self.scratch).ok()?;
        // Directions share numbers: a marker that moves along x and one that moves along y on a part that stands askew.
        let mut known: BTreeMap<Slot, usize> = BTreeMap::new();
        let mut by_slot: Vec<f64> = Vec::new();
        let mut out = DMatrix::zeros(n, directions.len());
        for (direction, mut dg) in directions.iter().zip(out.column_iter_mut()) {
            for (slot, weight) in direction.in_case(case).filter(|(_, weight)| *weight != 0.0) {
                let from = match known.entry(slot) {
                    Entry::Occupied(found) => *found.get(),
                    Entry::Vacant(place) => {
                        here.residual_by_slot(slot, &mut column).ok()?;
                        by_slot.extend_from_slice(&column);
                        *place.insert(by_slot.len() - n)
                    }
                };
                for (sum, value) in dg.iter_mut().zip(&by_slot[from..]) {
                    *sum += weight * value;
                }
            }
            for (marker, axis) in &direction.turns {
                here.residual_by_turn((*marker, axis), &mut column).ok()?;
                for (sum, value) in dg.iter_mut().zip(&column) {
                    *sum += value;
                }
            }
        }
        // What acts in other cases alone changes nothing here.
        let acting: Vec<usize> = (0..directions.len())
            .filter(|k| out.column(*k).iter().any(|value| *value != 0.0))
            .collect();
        if acting.len() == directions.len() {
            tangent.respond_to_all(out.as_mut_slice());
        } else {
            let mut own = out.select_columns(&acting);
            tangent.respond_to_all(own.as_mut_slice());
            for (column, k) in own.column_iter().zip(acting) {
                out.set_column(k, &column);
            }
        }
        self.sweeper.solver().give_back(tangent);
        Some(out)
    }

    /// Solves the first `common` load cases in their order, then sequences of so many cases each, every one as if it alone followed them.
    pub fn predict_apart(
        &mut self,
        numbers: &Numbers,
        directions: Option<&[Direction]>,
        common: usize,
        sequences: &[usize],
    ) -> Prediction {
        self.sweeps += 1;
        let mut theta = numbers.theta.clone();
        for weight in &self.weights {
            weight.hold(&mut theta);
        }
        let memories = std::mem::take(&mut self.memories);
        let mut carried = Carried::new(&memories, &theta, directions);
        let mut out = Vec::with_capacity(self.sweeper.cases());
        for case in 0..common {
            out.push(self.case(case, numbers, &mut theta, directions, &mut carried));
        }
        let mut next = common;
        for count in sequences {
            let mut carried = carried.clone();
            for case in next..next + count {
                out.push(self.case(case, numbers, &mut theta, directions, &mut carried));
            }
            next += count;
        }
        self.memories = memories;
        out
    }

    /// Solves one load case after what was `carried` from those before.
    fn case(
        &mut self,
        case: usize,
        numbers: &Numbers,
        theta: &mut Parameters,
        directions: Option<&[Direction]>,
        carried: &mut Carried<'_>,
    ) -> Option<CasePrediction> {
        for (slot, _) in &numbers.per_case {
            theta.set(*slot, numbers.theta.get(*slot));
        }
        self.sweeper.load(case, theta);
        for (slot, values) in &numbers.per_case {
            theta.set(*slot, theta.get(*slot) + values[case]);
        }
        carried.apply(theta);
        let mut state = self.solve(case, theta, &numbers.x)?;
        let (free, tangent) = self.settle_free(case, theta, &mut state);
        let channels = self.channels;
        let values = channels
            .values(self.system, theta, &state, &mut self.scratch)
            .ok()?;
        let mut prediction = CasePrediction {
            poses: state.poses.clone(),
            channels: values,
            by_unknown: CaseChanges::default(),
            free: CaseChanges::default(),
        };
        if free.ncols() > 0 {
            let nothing = vec![Direction::default(); free.ncols()];
            let changes = channel_changes(
                channels,
                self.system,
                (theta, case),
                &state,
                &mut self.scratch,
                (&nothing, &free),
            )
            .ok()?;
            prediction.free = self
                .observed
                .changes((self.system, &state), &free, &changes);
        }
        let mut response = Default::default();
        if let Some(directions) = directions {
            let mut room = std::mem::take(&mut self.directions);
            let directions = carried.directions(directions, case, &mut room);
            let responses = self.responses(case, theta, &state, (directions, tangent))?;
            let along = (directions, &responses);
            let changes = channel_changes(
                channels,
                self.system,
                (theta, case),
                &state,
                &mut self.scratch,
                along,
            )
            .ok()?;
            carried.advance(theta, &prediction.channels, (directions, &changes));
            prediction.by_unknown =
                self.observed
                    .changes((self.system, &state), &responses, &changes);
            let unknowns = directions.iter().map(|direction| direction.unknown);
            response = (unknowns.collect(), responses);
            self.directions = room;
        } else {
            if let Some(tangent) = tangent {
                self.sweeper.solver().give_back(tangent);
            }
            carried.advance(theta, &prediction.channels, (&[], &DMatrix::zeros(0, 0)));
        }
        self.sweeper.keep(case, state);
        self.answers[case] = Some(Arc::new(Answer {
            theta: theta.clone(),
            x: numbers.x.clone(),
            response,
        }));
        Some(prediction)
    }
}

/// First-order change of the unknowns of the system since the last answer; `None` where the unknowns of the fit are not the same
/// ones.
fn predicted(answer: &Answer, x: &[f64]) -> Option<Vec<f64>> {
    let (unknowns, responses) = &answer.response;
    if unknowns.is_empty() || answer.x.len() != x.len() {
        return None;
    }
    let mut correction = vec![0.0; responses.nrows()];
    for (unknown, response) in unknowns.iter().zip(responses.column_iter()) {
        let step = x[*unknown] - answer.x[*unknown];
        // Far steps are better started from the old answer than from a wild extrapolation.
        if !step.is_finite() || step.abs() > 0.5 {
            return None;
        }
        for (c, r) in correction.iter_mut().zip(response.iter()) {
            *c += step * r;
        }
    }
    Some(correction)
}

impl Predictor for NativePredictor<'_> {
    fn system(&self) -> &System {
        self.system
    }

    fn predict(&mut self, numbers: &Numbers, directions: Option<&[Direction]>) -> Prediction {
        let all = self.sweeper.cases();
        self.predict_apart(numbers, directions, all, &[])
    }

    /// A unit force within the spring deflects it by c = e^T T^-1 e, the tangent T holding the spring itself: its share is K c. Taken
    /// in the first case that has an answer; shares hardly depend on the load.
    fn shares(&mut self, springs: &[Component]) -> Option<Vec<f64>> {
        let case = self.answers.iter().position(Option::is_some)?;
        let theta = &self.answers[case].as_ref()?.theta;
        let state = self.sweeper.answer(case)?.clone();
        let solver = self.sweeper.solver();
        let mut tangent = solver.tangent(self.system, theta, &state).ok()?;
        let mut by_slot = vec![0.0; self.system.unknowns()];
        let mut out = Vec::with_capacity(springs.len());
        for spring in springs {
            let Some(preload) = spring.preload else {
                out.push(1.0);
                continue;
            };
            self.system
                .residual_by_slot(theta, &state, &mut self.scratch, preload, &mut by_slot)
                .ok()?;
            let mut response = by_slot.clone();
            tangent.respond(&mut response);
            let deflection: f64 = by_slot.iter().zip(&response).map(|(e, x)| e * x).sum();
            out.push((theta.get(spring.stiffness) * deflection).abs());
        }
        Some(out)
    }

    fn checkpoint(&mut self) {
        self.kept.states.clear();
        self.kept.states.extend_from_slice(self.sweeper.answers());
        self.kept.answers.clone_from(&self.answers);
    }

    fn rollback(&mut self) {
        if self.kept.answers.len() == self.answers.len() {
            self.sweeper.return_to(&self.kept.states);
            self.answers.clone_from(&self.kept.answers);
        }
    }

    fn sweeps(&self) -> usize {
        self.sweeps
    }

    fn solver_runs(&self) -> usize {
        self.runs
    }

    fn balance(&self) -> Option<&Balance> {
        self.sweeper.balance()
    }
}
