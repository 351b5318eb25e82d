//! Cost of a set of numbers: misses of goals and moves.

use std::ops::Range;

use crate::evaluation::Evaluation;
use crate::goal::{Goal, GoalKind};
use crate::tuning::Tuning;

impl Tuning {
    /// Returns the goals, each with the range of its rows among those of all goals.
    pub(crate) fn ranges(&self) -> impl Iterator<Item = (&Goal, Range<usize>)> {
        let mut first = 0;
        self.goals.iter().map(move |goal| {
            let range = first..first + goal.rows.len();
            first = range.end;
            (goal, range)
        })
    }

    /// Returns the cost of misses and moves: for each goal half the mean square of its misses or half the square of the largest, in units of
    /// its tolerance, and for each unknown half the square of its move, in units of its standard deviation. In a robust target the mean square
    /// has that of two standard deviations by the tolerances beside it, and the largest miss is that of the mean plus two of them.
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

    /// Returns the largest miss of a limit, in units of its tolerance.
    pub(crate) fn violation(&self, at: &Evaluation) -> f64 {
        let limits = self
            .ranges()
            .filter(|(goal, _)| goal.kind == GoalKind::Limit);
        limits
            .map(|(goal, rows)| goal_size(goal, rows, at) / goal.tolerance)
            .fold(0.0, f64::max)
    }

    /// Returns true if the values of all rows meet all goals, for the mean plus two standard deviations if the target is robust.
    pub(crate) fn meets(&self, at: &Evaluation) -> bool {
        self.ranges()
            .all(|(goal, rows)| largest_reach(goal, rows, at) <= goal.allowed())
    }
}

/// Returns the largest miss of a goal in its unit, for the mean plus two standard deviations if the target is robust.
pub(crate) fn largest_reach(goal: &Goal, rows: Range<usize>, at: &Evaluation) -> f64 {
    let each = goal.rows.iter().zip(rows);
    each.map(|(own, row)| own.reach(at.values[row], at.widening(row)))
        .fold(0.0, f64::max)
}

/// Returns the size that a search makes small: the root mean square of the misses of a goal, or the largest, in its unit.
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
