//! Predictor based on the built-in solver. Each load case is solved from its own last solution, extrapolated along the tangent.

use super::channel::{StateSensitivities, channel_changes};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use nalgebra::DMatrix;

use super::free::step;
use super::memory::{Carried, HysteresisState};
use super::predictor::{CaseChanges, CasePrediction, Observed, Prediction, Predictor};
use super::unknown::{Component, Direction, Numbers};
use crate::settings::{FREE_MAX_STEPS, MAX_EXTRAPOLATED_STEP};
use admire_session::backend::{CaseSweeper, FreeMotions, HeldWeight, Loads};
use admire_solver::model::PartIx;
use admire_solver::statics::{Balance, StaticSettings, Tangent, displace, twist};
use admire_solver::system::{Parameters, Scratch, Slot, State, System};
use admire_study::Channels;

/// Last solution of one load case, with its parameter values and sensitivities.
#[derive(Clone, Debug)]
struct CaseSolution {
    theta: Parameters,
    /// Values of the unknowns of the fit at the solution.
    x: Vec<f64>,
    /// Sensitivities: indices of the unknowns of the fit, and one column per index with the change of the solver's unknowns per unit of that
    /// unknown.
    response: (Vec<usize>, DMatrix<f64>),
}

/// Stored solutions of all load cases.
#[derive(Clone, Debug, Default)]
struct Checkpoint {
    states: Vec<Option<State>>,
    answers: Vec<Option<Arc<CaseSolution>>>,
}

/// Predictor of all load cases that uses the built-in solver.
#[derive(Debug)]
pub struct NativePredictor<'a> {
    system: &'a System,
    sweeper: CaseSweeper,
    observed: Observed,
    channels: Channels,
    scratch: Scratch,
    /// Reused storage for the directions of one load case.
    directions: Vec<Direction>,
    answers: Vec<Option<Arc<CaseSolution>>>,
    kept: Checkpoint,
    memories: Vec<HysteresisState>,
    /// Weights of freely spinning parts. Each acts as a force on the part that carries the spinning part.
    weights: Vec<HeldWeight>,
    /// True if the deck has free (zero-stiffness) motions.
    has_free_motions: bool,
    sweeps: usize,
    runs: usize,
}

impl<'a> NativePredictor<'a> {
    /// Creates the predictor for a compiled deck with its loads, the parts to observe and the channels.
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
            kept: Checkpoint::default(),
            memories: Vec::new(),
            weights: Vec::new(),
            has_free_motions: false,
            sweeper: CaseSweeper::new(system, loads, StaticSettings::tight()),
            system,
            observed,
            channels,
            sweeps: 0,
            runs: 0,
        }
    }

    /// Adds elements with memory, such as friction. The channels that measure their displacements must be among the channels passed to
    /// [`Self::new`].
    #[must_use]
    pub fn remembering(mut self, memories: Vec<HysteresisState>) -> Self {
        self.memories = memories;
        self
    }

    /// Declares the free motions of the deck. The weight of a freely spinning part then acts on the parts that carry it.
    #[must_use]
    pub(crate) fn with_free_motions(mut self, free: &FreeMotions) -> Self {
        self.weights = free.held_weights(self.system);
        self.has_free_motions = !free.is_empty();
        if self.has_free_motions {
            self.sweeper.solver().expect_free_motions();
        }
        self
    }

    /// Replaces the load cases by cases with these load values.
    #[must_use]
    pub fn with_cases(mut self, cases: Vec<Vec<f64>>) -> Self {
        self.answers = vec![None; cases.len()];
        self.sweeper.set_cases(cases);
        self
    }

    /// Sets the state from which a case is solved first, and the parameter values `theta` of that state. The state must belong to the same
    /// system.
    pub fn start_from(&mut self, case: usize, state: State, theta: Parameters) {
        self.sweeper.keep(case, state);
        self.answers[case] = Some(Arc::new(CaseSolution {
            theta,
            x: Vec::new(),
            response: Default::default(),
        }));
    }

    /// Returns the last solution of a case and the parameter values at which it was solved.
    pub fn answer(&self, case: usize) -> Option<(&State, &Parameters)> {
        let answer = self.answers[case].as_ref()?;
        Some((self.sweeper.answer(case)?, &answer.theta))
    }

    /// Solves one load case from its own last solution, extrapolated along the tangent to the unknowns `x`.
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

    /// Moves an equilibrium along its free motions to the best fit of the marks measured in its case. Returns the free motions at the new
    /// equilibrium, one column each, and the tangent there if it was computed.
    fn settle_free(
        &mut self,
        case: usize,
        theta: &Parameters,
        state: &mut State,
    ) -> (DMatrix<f64>, Option<Tangent>) {
        let (mut motions, mut last) = (Vec::new(), None);
        for taken in 0..=FREE_MAX_STEPS {
            // The last Newton factorisation was made before the equilibrium was reached and may miss a free motion. The flag of the deck is
            // therefore checked as well.
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
            let amounts = step(marks, &pose, &twists).filter(|_| taken < FREE_MAX_STEPS);
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

    /// Returns the derivatives of the solver's unknowns along each direction, one column each. `tangent` is computed if it is not given.
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
        // Several directions may contain the same slot, such as a coordinate of a marker. The derivative with respect to each slot is therefore
        // computed only once.
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
                here.residual_by_turn(*marker, axis, &mut column).ok()?;
                for (sum, value) in dg.iter_mut().zip(&column) {
                    *sum += value;
                }
            }
        }
        // Directions that act only in other load cases have zero columns in this case and need no solution.
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

    /// Solves the first `common` load cases in order, then several independent sequences of cases. `sequences` holds the number of cases in
    /// each sequence. Elements with memory start each sequence in the state that they have after the common cases.
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

    /// Solves one load case. `carried` holds the state of the elements with memory after the preceding cases, and is updated.
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
                theta,
                case,
                &state,
                &mut self.scratch,
                StateSensitivities {
                    directions: &nothing,
                    responses: &free,
                },
            )
            .ok()?;
            prediction.free = self.observed.changes(self.system, &state, &free, &changes);
        }
        let mut response = Default::default();
        if let Some(directions) = directions {
            let mut room = std::mem::take(&mut self.directions);
            let directions = carried.directions(directions, case, &mut room);
            let responses = self.responses(case, theta, &state, (directions, tangent))?;
            let along = StateSensitivities {
                directions,
                responses: &responses,
            };
            let changes = channel_changes(
                channels,
                self.system,
                theta,
                case,
                &state,
                &mut self.scratch,
                along,
            )
            .ok()?;
            carried.advance(theta, &prediction.channels, directions, &changes);
            prediction.by_unknown =
                self.observed
                    .changes(self.system, &state, &responses, &changes);
            let unknowns = directions.iter().map(|direction| direction.unknown);
            response = (unknowns.collect(), responses);
            self.directions = room;
        } else {
            if let Some(tangent) = tangent {
                self.sweeper.solver().give_back(tangent);
            }
            carried.advance(theta, &prediction.channels, &[], &DMatrix::zeros(0, 0));
        }
        self.sweeper.keep(case, state);
        self.answers[case] = Some(Arc::new(CaseSolution {
            theta: theta.clone(),
            x: numbers.x.clone(),
            response,
        }));
        Some(prediction)
    }
}

/// Returns the first-order change of the solver's unknowns from the last solution of a case to the unknowns `x`. Returns `None` if there are no
/// sensitivities, the number of unknowns differs, or a step is too large.
fn predicted(answer: &CaseSolution, x: &[f64]) -> Option<Vec<f64>> {
    let (unknowns, responses) = &answer.response;
    if unknowns.is_empty() || answer.x.len() != x.len() {
        return None;
    }
    let mut correction = vec![0.0; responses.nrows()];
    for (unknown, response) in unknowns.iter().zip(responses.column_iter()) {
        let step = x[*unknown] - answer.x[*unknown];
        // After a long step, the last solution itself is a better start than an extrapolation.
        if !step.is_finite() || step.abs() > MAX_EXTRAPOLATED_STEP {
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

    /// Computes the load share `K c` of each spring. A pair of unit forces at its ends deflects the spring by `c = e^T T^-1 e`, where the
    /// tangent `T` includes the spring itself. Only the first solved case is used, because the shares hardly depend on the load.
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
