//! Any backend as a predictor: sensitivities by central differences of whole runs.

use super::predictor::{CaseChange, CasePrediction, Observed, Prediction, Predictor};
use super::unknown::{Direction, Numbers};
use crate::backend::{Backend, BackendError, Load, LoadProgramme, SweepRequest};
use crate::identify::Problem;
use crate::mechanics::{Pose, log};
use crate::syntax::Address;
use crate::system::{Parameters, System};

/// Step of a difference, in units of an unknown: a thousandth of an e-fold, where truncation and the ten digits of a results file
/// are about as bad.
const STEP: f64 = 1e-3;

/// Predicts with a backend that only gives poses.
pub struct DifferencePredictor<'a> {
    problem: &'a Problem<'a>,
    system: &'a System,
    deck: Parameters,
    backend: &'a mut dyn Backend,
    observed: Observed,
    sweeps: usize,
    failure: Failure,
}

/// Why the last run that gave no answer at all gave none.
pub(super) type Failure = std::rc::Rc<std::cell::RefCell<Option<BackendError>>>;

impl<'a> DifferencePredictor<'a> {
    /// For a study's problem, its compiled deck and whoever solves it.
    pub fn new(
        problem: &'a Problem<'a>,
        system: &'a System,
        backend: &'a mut dyn Backend,
        observed: Observed,
    ) -> Self {
        Self {
            problem,
            system,
            deck: system.parameters(),
            backend,
            observed,
            sweeps: 0,
            failure: Failure::default(),
        }
    }

    /// Where failures of whole runs are told.
    pub(super) fn failure(&self) -> Failure {
        self.failure.clone()
    }

    /// Poses of every case at each of these numbers; the runs go side by side where the backend can.
    fn sweep(&mut self, all: &[Numbers]) -> Vec<Vec<Option<Vec<Pose>>>> {
        let cases = self.problem.programme.cases.len();
        let lasting =
            |failure: &Option<BackendError>| failure.as_ref().is_some_and(BackendError::is_lasting);
        if lasting(&self.failure.borrow()) {
            return vec![vec![None; cases]; all.len()];
        }
        self.sweeps += all.len();
        let catalogue = self.system.catalogue();
        let asked: Vec<(Vec<(Address, f64)>, LoadProgramme)> = all
            .iter()
            .map(|numbers| {
                let changed = catalogue.slots().filter(|slot| {
                    numbers.theta.get(*slot).to_bits() != self.deck.get(*slot).to_bits()
                });
                let theta = changed
                    .map(|slot| (catalogue.info(slot).address, numbers.theta.get(slot)))
                    .collect();
                (theta, self.programme(numbers))
            })
            .collect();
        let requests: Vec<SweepRequest<'_>> = asked
            .iter()
            .map(|(theta, programme)| SweepRequest {
                dataset: self.problem.dataset,
                model: self.problem.model,
                theta,
                programme,
            })
            .collect();
        let answers = self.backend.sweeps(&requests);
        answers
            .into_iter()
            .map(|answer| match answer {
                Ok(sweep) => (0..cases)
                    .map(|case| sweep.equilibrium(case).map(|e| e.poses.clone()))
                    .collect(),
                Err(error) => {
                    let mut failure = self.failure.borrow_mut();
                    if !lasting(&failure) {
                        *failure = Some(error);
                    }
                    vec![None; cases]
                }
            })
            .collect()
    }

    /// The study's programme with what the unknowns add from case to case.
    fn programme(&self, numbers: &Numbers) -> LoadProgramme {
        let mut programme = self.problem.programme.clone();
        for (slot, values) in &numbers.per_case {
            let target = self.system.catalogue().info(*slot).address;
            let column = programme
                .loads
                .iter()
                .position(|load| load.target == target)
                .unwrap_or_else(|| {
                    let base = numbers.theta.get(*slot);
                    programme.loads.push(Load {
                        name: target.to_string(),
                        target: target.clone(),
                    });
                    programme
                        .cases
                        .iter_mut()
                        .for_each(|case| case.values.push(base));
                    programme.loads.len() - 1
                });
            for (case, value) in programme.cases.iter_mut().zip(values) {
                case.values[column] += value;
            }
        }
        programme
    }
}

/// The numbers moved along a direction.
fn moved(numbers: &Numbers, direction: &Direction, step: f64) -> Numbers {
    let mut next = numbers.clone();
    for (slot, factor) in &direction.always {
        next.theta.set(*slot, next.theta.get(*slot) + step * factor);
    }
    for (slot, factors) in &direction.per_case {
        next.per_case
            .push((*slot, factors.iter().map(|f| f * step).collect()));
    }
    for (marker, axis) in &direction.turns {
        next.theta.turn(*marker, axis, step);
    }
    next
}

impl Predictor for DifferencePredictor<'_> {
    fn system(&self) -> &System {
        self.system
    }

    fn predict(&mut self, numbers: &Numbers, directions: Option<&[Direction]>) -> Prediction {
        let directions = directions.unwrap_or_default();
        let mut all = vec![numbers.clone()];
        for direction in directions {
            all.extend([STEP, -STEP].map(|step| moved(numbers, direction, step)));
        }
        let mut swept = self.sweep(&all).into_iter();
        let mut next = || swept.next().expect("an answer for each request");
        let mut out: Prediction = next()
            .into_iter()
            .map(|poses| {
                Some(CasePrediction {
                    poses: poses?,
                    channels: Vec::new(),
                    by_unknown: Vec::new(),
                })
            })
            .collect();
        for _ in directions {
            let (up, down) = (next(), next());
            for (prediction, (up, down)) in out.iter_mut().zip(up.iter().zip(&down)) {
                let change = |part: &crate::model::PartIx| {
                    let (Some(up), Some(down)) = (up, down) else {
                        return [f64::NAN; 6];
                    };
                    let (up, down) = (&up[part.0], &down[part.0]);
                    let (dp, dr) = (up.p - down.p, log(&(up.R * down.R.transpose())));
                    [dp.x, dp.y, dp.z, dr.x, dr.y, dr.z].map(|value| value / (2.0 * STEP))
                };
                if let Some(prediction) = prediction {
                    let parts = self.observed.parts.iter().map(change).collect();
                    prediction.by_unknown.push(CaseChange {
                        parts,
                        channels: Vec::new(),
                    });
                }
            }
        }
        // A case whose neighbours have no equilibrium has no derivative and so no use.
        let usable = |p: &CasePrediction| {
            p.by_unknown
                .iter()
                .flat_map(|c| &c.parts)
                .flatten()
                .all(|v| v.is_finite())
        };
        out.into_iter()
            .map(|prediction| prediction.filter(usable))
            .collect()
    }

    fn sweeps(&self) -> usize {
        self.sweeps
    }

    fn solver_runs(&self) -> usize {
        self.sweeps * self.problem.programme.cases.len()
    }
}
