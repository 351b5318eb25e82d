//! Analysis of a solution: gradients at the bounds, conflicts between goals, and sensitivities.

use std::ops::Range;

use crate::evaluation::Evaluation;
use crate::goal::GoalKind;
use crate::settings::{AT_BOUND, CONFLICT_COSINE};
use crate::tuning::Tuning;
use admire_study::UnknownForm;
use nalgebra::DVector;
use serde::Serialize;

/// Two conflicting goals: within the bounds, improving one makes the other worse.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Conflict {
    /// Names of the goals.
    pub goals: [String; 2],
    /// Cosine of the angle between the steepest-descent directions of the two costs, within the bounds. The unknowns are scaled by their
    /// natural sizes.
    pub cosine: f64,
}

/// Returns the gradient of each goal's cost with respect to the coordinates. For a minimax goal or a limit, `pulls` (the multiplier of each
/// row) weights the gradients of the rows.
fn goal_gradients(tuning: &Tuning, end: &Evaluation, pulls: &[f64]) -> Vec<DVector<f64>> {
    let mut row = 0;
    let mut all = Vec::new();
    for goal in &tuning.goals {
        let mut sum = DVector::zeros(tuning.unknowns.len());
        for own in &goal.rows {
            let miss = own.miss(end.values[row]) / goal.tolerance;
            let pull = match goal.kind {
                GoalKind::Squares => miss / goal.rows.len() as f64,
                GoalKind::Minimax | GoalKind::Limit => {
                    let middle = 0.5 * (own.wanted[0] + own.wanted[1]);
                    let side = if middle.is_finite() {
                        end.values[row] - middle
                    } else if own.wanted[0].is_finite() {
                        -1.0
                    } else {
                        1.0
                    };
                    pulls.get(row).copied().unwrap_or(0.0) * side.signum()
                }
            };
            sum += end.jacobian.row(row).transpose() * (pull / goal.tolerance);
            if end.spread.is_some() {
                // Two standard deviations are a miss of their own, or add to the one that is limited.
                let apart = match goal.kind {
                    GoalKind::Squares => {
                        let own = end.widening(row) / goal.tolerance;
                        own / goal.rows.len() as f64
                    }
                    GoalKind::Minimax | GoalKind::Limit => pull.abs(),
                };
                sum += end.widening_change(row).transpose() * (apart / goal.tolerance);
            }
            row += 1;
        }
        all.push(sum);
    }
    all
}

/// Returns the gradient of the total cost with respect to the coordinates. Limits enter through their multipliers.
pub(crate) fn gradient(
    tuning: &Tuning,
    end: &Evaluation,
    pulls: &[f64],
    x: &[f64],
) -> DVector<f64> {
    let mut sum = DVector::from_iterator(
        x.len(),
        tuning.unknowns.iter().zip(x).map(|(unknown, x)| {
            let sd = unknown.sd;
            (x - unknown.mean) / (sd * sd)
        }),
    );
    for own in goal_gradients(tuning, end, pulls) {
        sum += own;
    }
    sum
}

/// Returns the conflicting pairs among the goals that are missed and the limits that are reached. Two goals conflict if, within the bounds,
/// improving one makes the other worse.
pub(crate) fn conflicts(tuning: &Tuning, end: &Evaluation, x: &[f64]) -> Vec<Conflict> {
    // A limit acts wherever it is reached, so only the sign of its side counts.
    let reached: Vec<f64> = vec![1.0; end.values.len()];
    let scale = tuning.scale();
    let mut row = 0;
    let mut directions = Vec::new();
    for (goal, gradient) in tuning
        .goals
        .iter()
        .zip(goal_gradients(tuning, end, &reached))
    {
        let rows = row..row + goal.rows.len();
        row = rows.end;
        let worst = goal
            .rows
            .iter()
            .zip(rows)
            .map(|(own, row)| (own, end.values[row], end.widening(row)))
            .map(|(own, value, widening)| match goal.kind {
                // A limit that is reached stands in the way, though it is met.
                GoalKind::Limit => {
                    let [least, most] = own.wanted;
                    let room = ((value - least).min(most - value) - widening) / goal.tolerance;
                    if room < 0.1 { 2.0 } else { 0.0 }
                }
                GoalKind::Squares | GoalKind::Minimax => {
                    own.reach(value, widening) / goal.tolerance
                }
            })
            .fold(0.0, f64::max);
        if worst <= 1.0 {
            continue;
        }
        let along = DVector::from_fn(x.len(), |k, _| {
            let down = -gradient[k] * scale[k];
            let [least, most] = tuning.unknowns[k].bounds;
            let near = AT_BOUND * (most - least);
            let blocked =
                (x[k] <= least + near && down < 0.0) || (x[k] >= most - near && down > 0.0);
            if blocked { 0.0 } else { down }
        });
        directions.push((goal.name(), along));
    }
    let mut found = Vec::new();
    for (k, (name, own)) in directions.iter().enumerate() {
        for (other, theirs) in &directions[k + 1..] {
            let size = own.norm() * theirs.norm();
            let cosine = if size > 0.0 {
                own.dot(theirs) / size
            } else {
                0.0
            };
            if cosine < CONFLICT_COSINE {
                found.push(Conflict {
                    goals: [name.clone(), other.clone()],
                    cosine,
                });
            }
        }
    }
    found.sort_by(|a, b| a.cosine.total_cmp(&b.cosine));
    found
}

/// Returns the change of a goal's value per unit of each unknown, or per percent of a factor. For a single row, the sign is kept. For several
/// rows, the result is the root mean square of their changes.
pub(crate) fn sensitivities(
    tuning: &Tuning,
    end: &Evaluation,
    rows: Range<usize>,
    x: &[f64],
) -> Vec<f64> {
    let each = tuning.unknowns.iter().zip(x).enumerate();
    each.map(|(k, (unknown, x))| {
        let per = match unknown.form {
            UnknownForm::Factor => 0.01,
            UnknownForm::Change | UnknownForm::Value => 1.0 / unknown.shown_rate(*x),
        };
        let column = end.jacobian.column(k);
        let own = column.rows(rows.start, rows.len());
        if rows.len() == 1 {
            return per * own[0];
        }
        per * (own.norm_squared() / rows.len() as f64).sqrt()
    })
    .collect()
}

/// Returns the share of each unknown in the changes of the goals' values. The change by an unknown follows from its own move from the value in
/// the deck to the solution, in the linear model at the solution. Changes are in units of the tolerances. Their squares are averaged over the
/// rows of each goal and added over the goals. The shares are the roots of these sums, divided by their total.
pub(crate) fn contributions(tuning: &Tuning, end: &Evaluation, x: &[f64]) -> Vec<f64> {
    let mut weights = Vec::new();
    for goal in &tuning.goals {
        let weight = 1.0 / (goal.tolerance * (goal.rows.len() as f64).sqrt());
        weights.extend(std::iter::repeat_n(weight, goal.rows.len()));
    }
    let size = |k: usize| {
        let moved = x[k] - tuning.unknowns[k].deck();
        let column = end.jacobian.column(k);
        let squares = column.iter().zip(&weights).map(|(entry, weight)| {
            let change = entry * moved * weight;
            change * change
        });
        squares.sum::<f64>().sqrt()
    };
    let sizes: Vec<f64> = (0..x.len()).map(size).collect();
    let all: f64 = sizes.iter().sum();
    let share = |size: &f64| if all > 0.0 { size / all } else { 0.0 };
    sizes.iter().map(share).collect()
}
