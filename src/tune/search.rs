//! Searches from several starts.

use sobol::Sobol;
use sobol::params::JoeKuoD6;

use crate::evaluation::Evaluator;
use crate::found::Found;
use crate::outcome::Outcome;
use crate::problem::{Problem, Watch};
use crate::settings::{
    CONVERGED_DECREMENT, CONVERGED_STEP, ENOUGH_REDUCTION, LIMIT_SLACK, MAX_PENALTY,
    MULTIPLIER_ROUNDS, PENALTY_GROWTH,
};
use crate::tune_error::TuneError;
use crate::tuning::Tuning;
use admire_identify::global::gauss_newton::{Ending, Tolerances, minimise};

/// Number of dimensions up to which the small table of direction numbers suffices.
const SMALL_TABLE: usize = 100;

impl Tuning {
    /// Searches from the start of the study and from Sobol points within the bounds.
    ///
    /// `watch` receives the number of the start and the number of evaluations so far. It returns false to stop. A stopped search still has an
    /// outcome.
    ///
    /// # Errors
    /// [`TuneError`] if the axle has no equilibrium at any start.
    pub fn search(
        &self,
        watch: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Outcome, TuneError> {
        let mut evaluator = Evaluator::new(self);
        let mut found: Vec<Found> = Vec::new();
        let mut goes_on = true;
        for (k, start) in self.starts().into_iter().enumerate() {
            if !goes_on {
                break;
            }
            let mut tell = |evaluations: usize| {
                goes_on = watch(k, evaluations);
                goes_on
            };
            found.push(search_from(&mut evaluator, &start, &mut tell));
        }
        Outcome::of(self, &mut evaluator, found)
    }

    /// Returns the starts: that of the study, then the points of the Sobol sequence within the bounds, from its second point on.
    fn starts(&self) -> Vec<Vec<f64>> {
        let (count, restarts) = (self.unknowns.len(), self.target.restarts);
        let mut all = vec![self.start()];
        if restarts == 0 {
            return all;
        }
        let table = if count > SMALL_TABLE {
            JoeKuoD6::standard()
        } else {
            JoeKuoD6::minimal()
        };
        let points = Sobol::<f64>::new(count, &table).skip(1).take(restarts);
        all.extend(points.map(|point| {
            let each = self.unknowns.iter().zip(point);
            each.map(|(unknown, u)| {
                let [least, most] = unknown.bounds;
                least + u * (most - least)
            })
            .collect()
        }));
        all
    }
}

/// Searches from one start, in rounds of multipliers if there are constraints.
fn search_from<'b>(
    evaluator: &'b mut Evaluator<'_>,
    start: &[f64],
    watch: &'b mut Watch<'b>,
) -> Found {
    let tuning = evaluator.tuning;
    let mut problem = Problem::new(evaluator, watch);
    let mut found = Found {
        start: start.to_vec(),
        x: start.to_vec(),
        end: None,
        cost: f64::INFINITY,
        violation: f64::INFINITY,
        pulls: Vec::new(),
        is_converged: false,
        evaluations: 0,
    };
    let Some(first) = problem.at(start).cloned() else {
        found.evaluations = problem.evaluations;
        return found;
    };
    let mut x = start.to_vec();
    let largest = problem.largest_misses(&first.values);
    let mut scale = tuning.scale();
    scale.extend(largest.iter().map(|t| t.max(1.0)));
    x.extend(largest);
    found.end = Some(first);
    let (priors, held) = (problem.priors(), vec![false; x.len()]);
    let mut before = f64::INFINITY;
    for _ in 0..MULTIPLIER_ROUNDS {
        let tolerances = Tolerances {
            decrement: CONVERGED_DECREMENT,
            step: CONVERGED_STEP,
            max_iterations: 1 + problem.most - problem.evaluations.min(problem.most),
        };
        let Some(minimum) = minimise(&mut problem, &x, &priors, &scale, &held, tolerances) else {
            break;
        };
        x = minimum.x;
        let (own, largest) = x.split_at(tuning.unknowns.len());
        let Some(end) = problem.at(own).cloned() else {
            break;
        };
        let constrained = problem.constraint_values(&end.values, largest);
        let mut violation: f64 = 0.0;
        // Largest remaining violation: miss of a constraint, or slack of a constraint with a positive multiplier.
        let mut unsettled: f64 = 0.0;
        for (value, multiplier) in constrained.iter().zip(&mut problem.multipliers) {
            violation = violation.max(*value);
            unsettled = unsettled.max(value.max(-*multiplier / problem.penalty).abs());
            *multiplier = (*multiplier + problem.penalty * value).max(0.0);
        }
        found.x = own.to_vec();
        found.end = Some(end);
        found.violation = violation;
        let is_settled = minimum.ending == Ending::Converged;
        found.is_converged = is_settled && unsettled <= LIMIT_SLACK;
        if found.is_converged
            || minimum.ending == Ending::Stopped
            || problem.evaluations >= problem.most
        {
            break;
        }
        if !is_settled && constrained.is_empty() {
            break;
        }
        if unsettled > ENOUGH_REDUCTION * before {
            problem.penalty = (PENALTY_GROWTH * problem.penalty).min(MAX_PENALTY);
        }
        before = unsettled;
    }
    let mut pulls = vec![0.0; tuning.goals.iter().map(|goal| goal.rows.len()).sum()];
    for (own, multiplier) in problem.constraints.iter().zip(&problem.multipliers) {
        pulls[own.row] += multiplier;
    }
    found.pulls = pulls;
    found.evaluations = problem.evaluations;
    if let Some(end) = &found.end {
        found.cost = tuning.cost(&end.values, &found.x);
        found.violation = tuning.violation(&end.values);
    }
    found
}
