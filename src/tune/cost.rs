//! Cost of a set of values of the unknowns: misses of the goals, and moves of the unknowns.

use std::ops::Range;

use crate::evaluation::Evaluation;
use crate::goal::{Goal, GoalKind};
use crate::tuning::Tuning;

impl Tuning {
    /// Returns each goal with the range of its rows in the list of the rows of all goals.
    pub(crate) fn ranges(&self) -> impl Iterator<Item = (&Goal, Range<usize>)> {
        let mut first = 0;
        self.goals.iter().map(move |goal| {
            let range = first..first + goal.rows.len();
            first = range.end;
            (goal, range)
        })
    }

    /// Returns the cost of the misses and moves. A goal costs half the mean square of its misses, or half the square of its largest miss if
    /// it is a minimax goal. Misses are in units of the tolerance. Limits cost nothing. An unknown costs half the square of its move, in
    /// units of its standard deviation.
    ///
    /// In a robust target, each row has a margin: two standard deviations of its value due to the tolerances. The mean square of the margins is
    /// added to that of the misses. In a minimax goal, the largest miss includes the margin.
    pub(crate) fn cost(&self, at: &Evaluation, x: &[f64]) -> f64 {
        let goals = self.ranges().map(|(goal, rows)| {
            let size = goal_size(goal, rows, at) / goal.tolerance;
            match goal.kind {
                GoalKind::Squares | GoalKind::Minimax => 0.5 * goal.weight * size * size,
                GoalKind::Limit => 0.0,
            }
        });
        let moves = self.unknowns.iter().zip(x).map(|(unknown, x)| {
            let away = (x - unknown.mean) / unknown.sd;
            0.5 * away * away
        });
        goals.sum::<f64>() + moves.sum::<f64>()
    }

    /// Returns the largest miss of any limit, in units of the tolerance of that limit.
    pub(crate) fn violation(&self, at: &Evaluation) -> f64 {
        let limits = self
            .ranges()
            .filter(|(goal, _)| goal.kind == GoalKind::Limit);
        limits
            .map(|(goal, rows)| goal_size(goal, rows, at) / goal.tolerance)
            .fold(0.0, f64::max)
    }

    /// Returns true if all rows meet their goals. A robust target must meet them at two standard deviations to either side of the mean.
    pub(crate) fn meets(&self, at: &Evaluation) -> bool {
        self.ranges()
            .all(|(goal, rows)| largest_reach(goal, rows, at) <= goal.allowed())
    }
}

/// Returns the largest miss of a goal, in the unit of the goal. In a robust target, it is the largest miss within two standard deviations
/// of the mean.
pub(crate) fn largest_reach(goal: &Goal, rows: Range<usize>, at: &Evaluation) -> f64 {
    let each = goal.rows.iter().zip(rows);
    each.map(|(own, row)| own.reach(at.values[row], at.widening(row)))
        .fold(0.0, f64::max)
}

/// Returns the measure of a goal's misses that the search minimises, in the unit of the goal. It is the largest miss of a minimax goal or
/// limit, and the root mean square of the misses of any other goal.
pub(crate) fn goal_size(goal: &Goal, rows: Range<usize>, at: &Evaluation) -> f64 {
    if goal.kind != GoalKind::Squares {
        return largest_reach(goal, rows, at);
    }
    let squares = goal.rows.iter().zip(rows).map(|(own, row)| {
        let (miss, widening) = (own.miss(at.values[row]), at.widening(row));
        miss * miss + widening * widening
    });
    (squares.sum::<f64>() / goal.rows.len() as f64).sqrt()
}
