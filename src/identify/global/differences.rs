//! Predictor for any backend, with sensitivities by central differences of whole sweeps.

use super::predictor::{CaseChange, CaseChanges, CasePrediction, Observed, Prediction, Predictor};
use super::prepared::Prepared;
use super::unknown::{Direction, Numbers};
use crate::Problem;
use crate::free_motions::{changes_along, meet_marks};
use crate::settings::DIFFERENCE_STEP;
use admire_session::backend::{Backend, BackendError, Load, LoadProgramme, SweepRequest, slot};
use admire_solver::mechanics::{Pose, log};
use admire_solver::statics::Balance;
use admire_solver::system::{Parameters, Scratch, System};
use admire_study::Channels;
use admire_syntax::Address;

/// Predictor for a backend that returns only the poses of the parts. Channels are evaluated from these poses.
pub(crate) struct DifferencePredictor<'a> {
    problem: &'a Problem<'a>,
    system: &'a System,
    channels: Channels,
    scratch: Scratch,
    deck: Parameters,
    backend: &'a mut dyn Backend,
    observed: Observed,
    sweeps: usize,
    failure: Failure,
}

/// Poses of the parts in one case, and the channel values at these poses.
#[derive(Clone, Debug)]
struct CaseValues {
    poses: Vec<Pose>,
    channels: Vec<f64>,
}

/// Shared record of the last error that made a whole sweep fail, if any. A persistent error, which would recur at other parameter values,
/// is not overwritten by later errors.
pub(super) type Failure = std::rc::Rc<std::cell::RefCell<Option<BackendError>>>;

impl<'a> DifferencePredictor<'a> {
    /// Creates the predictor for a problem with its compiled deck, a backend, and the parts to observe.
    pub(crate) fn new(
        problem: &'a Problem<'a>,
        prepared: &'a Prepared,
        backend: &'a mut dyn Backend,
        observed: Observed,
    ) -> Self {
        let system = &prepared.system;
        Self {
            problem,
            system,
            channels: prepared.channels,
            scratch: Scratch::new(system),
            deck: system.parameters(),
            backend,
            observed,
            sweeps: 0,
            failure: Failure::default(),
        }
    }

    /// Returns the shared record of failed sweeps.
    pub(super) fn failure(&self) -> Failure {
        self.failure.clone()
    }

    /// Solves every load case for each set of parameter values in `all`. The backend may run the sets in parallel.
    fn sweep(&mut self, all: &[Numbers]) -> Vec<Vec<Option<CaseValues>>> {
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
        let mut out = Vec::with_capacity(all.len());
        for (answer, (numbers, (_, programme))) in answers.into_iter().zip(all.iter().zip(&asked)) {
            let sweep = match answer {
                Ok(sweep) => sweep,
                Err(error) => {
                    let mut failure = self.failure.borrow_mut();
                    if !lasting(&failure) {
                        *failure = Some(error);
                    }
                    out.push(vec![None; cases]);
                    continue;
                }
            };
            let mut answers = Vec::with_capacity(cases);
            for case in 0..cases {
                let poses = sweep.equilibrium(case).map(|found| {
                    let mut poses = found.poses.clone();
                    let marks = self.observed.marks.get(case).map_or(&[][..], Vec::as_slice);
                    meet_marks(self.problem.free, &mut poses, &self.observed, marks);
                    poses
                });
                answers.push(poses.and_then(|poses| self.read(numbers, (programme, case), poses)));
            }
            out.push(answers);
        }
        out
    }

    /// Evaluates the channels at the poses of a case. Returns `None` if a channel has no value there.
    fn read(
        &mut self,
        numbers: &Numbers,
        (programme, case): (&LoadProgramme, usize),
        poses: Vec<Pose>,
    ) -> Option<CaseValues> {
        let mut theta = numbers.theta.clone();
        for (load, value) in programme.loads.iter().zip(&programme.cases[case].values) {
            // A load on a parameter that the built-in solver does not have affects none of the channels.
            if let Ok(slot) = slot(self.system, &load.target) {
                theta.set(slot, *value);
            }
        }
        let values = self
            .channels
            .at(self.system, &theta, &poses, &mut self.scratch);
        let channels = values.into_iter().collect::<Option<_>>()?;
        Some(CaseValues { poses, channels })
    }

    /// Returns the load programme of the study with the per-case contributions of `numbers` added to the load values.
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

/// Returns the parameter values after a step of the given length along a direction.
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
            all.extend(
                [DIFFERENCE_STEP, -DIFFERENCE_STEP].map(|step| moved(numbers, direction, step)),
            );
        }
        let mut swept = self.sweep(&all).into_iter();
        let mut next = || swept.next().expect("an answer for each request");
        let mut out: Prediction = next()
            .into_iter()
            .map(|answer| {
                let answer = answer?;
                let count = answer.channels.len();
                let free = &self.problem.free;
                Some(CasePrediction {
                    free: changes_along(free, &answer.poses, &self.observed, count),
                    poses: answer.poses,
                    channels: answer.channels,
                    by_unknown: CaseChanges::default(),
                })
            })
            .collect();
        for _ in directions {
            let (up, down) = (next(), next());
            for (prediction, (up, down)) in out.iter_mut().zip(up.iter().zip(&down)) {
                let change = |part: &admire_solver::model::PartIx| {
                    let (Some(up), Some(down)) = (up, down) else {
                        return [f64::NAN; 6];
                    };
                    let (up, down) = (&up.poses[part.0], &down.poses[part.0]);
                    let (dp, dr) = (up.p - down.p, log(&(up.R * down.R.transpose())));
                    [dp.x, dp.y, dp.z, dr.x, dr.y, dr.z]
                        .map(|value| value / (2.0 * DIFFERENCE_STEP))
                };
                if let Some(prediction) = prediction {
                    let parts = self.observed.parts.iter().map(change);
                    let channel = |k: usize| match (up, down) {
                        (Some(up), Some(down)) => {
                            (up.channels[k] - down.channels[k]) / (2.0 * DIFFERENCE_STEP)
                        }
                        _ => f64::NAN,
                    };
                    let channels = (0..prediction.channels.len()).map(channel);
                    prediction.by_unknown.push(parts, channels);
                }
            }
        }
        // A case without an equilibrium on both sides of a difference has no derivatives, so it counts as unsolved.
        let usable = |p: &CasePrediction| {
            let values = |c: CaseChange<'_>| {
                let mut all = c.parts.iter().flatten().chain(c.channels);
                all.all(|value| value.is_finite())
            };
            p.by_unknown.iter().all(values)
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

    fn balance(&self) -> Option<&Balance> {
        self.backend.balance()
    }
}
