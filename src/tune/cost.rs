//! Cost of a set of numbers: misses of goals and moves.

use crate::evaluation::values;
use crate::goal::{Goal, GoalKind};
use crate::tuning::Tuning;

impl Tuning {
    /// Returns the cost of misses and moves. Each goal costs half the mean square of its misses, or half the square of its largest miss, in
    /// units of its tolerance. Each unknown costs half the square of its move, in units of its standard deviation.
    pub(crate) fn cost(&self, values: &[f64], x: &[f64]) -> f64 {
        let goals: f64 = self.goal_costs(values).iter().sum();
        let moves = self.unknowns.iter().zip(x).map(|(unknown, x)| {
            let away = (x - unknown.mean) / unknown.sd;
            0.5 * away * away
        });
        goals + moves.sum::<f64>()
    }

    /// Returns the cost of each goal; zero for limits.
    pub(crate) fn goal_costs(&self, values: &[f64]) -> Vec<f64> {
        let mut values = values.iter();
        let of = |goal: &Goal| {
            let misses: Vec<f64> = goal
                .rows
                .iter()
                .zip(&mut values)
                .map(|(row, value)| row.miss(*value) / goal.tolerance)
                .collect();
            match goal.kind {
                GoalKind::Squares => {
                    0.5 * misses.iter().map(|miss| miss * miss).sum::<f64>() / misses.len() as f64
                }
                GoalKind::Minimax => {
                    0.5 * misses.iter().map(|miss| miss * miss).fold(0.0, f64::max)
                }
                GoalKind::Limit => 0.0,
            }
        };
        self.goals.iter().map(of).collect()
    }

    /// Returns the largest miss of a limit, in units of its tolerance.
    pub(crate) fn violation(&self, values: &[f64]) -> f64 {
        let mut values = values.iter();
        let mut worst: f64 = 0.0;
        for goal in &self.goals {
            for (row, value) in goal.rows.iter().zip(&mut values) {
                if goal.kind == GoalKind::Limit {
                    worst = worst.max((row.miss(*value) / goal.tolerance).abs());
                }
            }
        }
        worst
    }

    /// Returns the values of all rows for the original deck.
    pub(crate) fn values_before(&self) -> Vec<f64> {
        values(self, &self.before)
    }
}
