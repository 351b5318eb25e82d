//! Search from one start.

use crate::evaluation::Evaluator;
use crate::found::Found;
use crate::problem::{Problem, Watch};
use crate::settings::{
    CONVERGED_DECREMENT, CONVERGED_STEP, ENOUGH_REDUCTION, LIMIT_SLACK, MAX_PENALTY,
    MULTIPLIER_ROUNDS, PENALTY_GROWTH,
};
use admire_identify::global::gauss_newton::{Ending, Tolerances, minimise};

/// Searches from one start. If there are constraints, the search consists of rounds of the method of multipliers.
pub(crate) fn search_from<'b>(
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
    let largest = problem.largest_misses(&first);
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
        // The end of a search that has used up its evaluations takes one more.
        let end = problem.at(own).cloned();
        let Some(end) = end.or_else(|| problem.evaluator.evaluate(own, true)) else {
            break;
        };
        let constrained = problem.constraint_values(&end, largest);
        let mut violation: f64 = 0.0;
        // The miss of a constraint, or the slack of one whose multiplier still pulls.
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
        found.cost = tuning.cost(end, &found.x);
        found.violation = tuning.violation(end);
    }
    found
}
