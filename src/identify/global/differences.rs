//! Any backend as a predictor: sensitivities by central differences of whole runs.

use super::predictor::{CaseChange, CasePrediction, Observed, Prediction, Predictor};
use super::unknown::{Direction, Numbers};
use crate::backend::{Backend, Load, LoadProgramme, SweepRequest};
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
}

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
        }
    }

    fn sweep(&mut self, numbers: &Numbers) -> Vec<Option<Vec<Pose>>> {
        self.sweeps += 1;
        let catalogue = self.system.catalogue();
        let theta: Vec<(Address, f64)> = catalogue
            .slots()
            .filter(|slot| numbers.theta.get(*slot).to_bits() != self.deck.get(*slot).to_bits())
            .map(|slot| (catalogue.info(slot).address, numbers.theta.get(slot)))
            .collect();
        let programme = self.programme(numbers);
        let request = SweepRequest {
            dataset: self.problem.dataset,
            model: self.problem.model,
            theta: &theta,
            programme: &programme,
        };
        let cases = self.problem.programme.cases.len();
        match self.backend.sweep(&request) {
            Ok(sweep) => (0..cases)
                .map(|case| sweep.equilibrium(case).map(|e| e.poses.clone()))
                .collect(),
            Err(_) => vec![None; cases],
        }
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
    next
}

impl Predictor for DifferencePredictor<'_> {
    fn system(&self) -> &System {
        self.system
    }

    fn predict(&mut self, numbers: &Numbers, directions: Option<&[Direction]>) -> Prediction {
        let centre = self.sweep(numbers);
        let mut out: Prediction = centre
            .into_iter()
            .map(|poses| {
                Some(CasePrediction {
                    poses: poses?,
                    channels: Vec::new(),
                    by_unknown: Vec::new(),
                })
            })
            .collect();
        for direction in directions.unwrap_or_default() {
            let up = self.sweep(&moved(numbers, direction, STEP));
            let down = self.sweep(&moved(numbers, direction, -STEP));
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
