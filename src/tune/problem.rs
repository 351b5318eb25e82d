//! The least-squares problem of a search: misses of goals, cost of moves, and constraints by the method of multipliers.

use crate::evaluation::{Evaluation, Evaluator};
use crate::goal::GoalKind;
use crate::settings::FIRST_PENALTY;
use admire_identify::global::Evaluation as Residuals;
use admire_identify::global::gauss_newton::{LeastSquares, Prior};
use nalgebra::{DMatrix, DVector};

/// Callback that receives the number of evaluations from the current start. It returns false to stop the search.
pub type Watch<'a> = dyn FnMut(usize) -> bool + 'a;

/// Constraint `(sign (value - bound) + widening) / tolerance - t <= 0` on a value. `t` is the largest miss of a minimax goal, and zero for a
/// limit. The widening is a multiple of the standard deviation that the tolerances cause. It is zero if the target is not robust.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constraint {
    /// Index of the value in the list of the rows of all goals.
    pub row: usize,
    /// Index of the goal.
    pub goal: usize,
    sign: f64,
    bound: f64,
    /// Index of `t` among the largest misses of the minimax goals; `None` for a limit.
    largest: Option<usize>,
}

/// Least-squares problem of a search. Its unknowns are the coordinates of the deck's unknowns, followed by the largest miss of each minimax
/// goal.
///
/// A constraint `c <= 0` adds `max(0, c + lambda / rho)^2 rho / 2` to the cost, with the multiplier `lambda` and the penalty `rho`. Source:
/// the augmented Lagrangian for inequalities (Rockafellar 1973; Conn, Gould and Toint, Trust-Region Methods, section 14.4).
pub(crate) struct Problem<'a, 'b> {
    pub evaluator: &'b mut Evaluator<'a>,
    pub constraints: Vec<Constraint>,
    /// Multiplier of each constraint.
    pub multipliers: Vec<f64>,
    /// Penalty on the constraints.
    pub penalty: f64,
    /// Number of evaluations with derivatives.
    pub evaluations: usize,
    /// Number of evaluations after which the search stops.
    pub most: usize,
    /// Cache of at most two evaluations. The one used last is at the end.
    kept: Vec<Evaluation>,
    /// Number of minimax goals, each of which has a largest miss as an unknown.
    pub largest: usize,
    /// Callback that observes the search and can stop it.
    pub watch: &'b mut Watch<'b>,
    /// True once the callback has stopped the search.
    pub is_stopped: bool,
}

impl<'a, 'b> Problem<'a, 'b> {
    pub(crate) fn new(evaluator: &'b mut Evaluator<'a>, watch: &'b mut Watch<'b>) -> Self {
        let mut constraints = Vec::new();
        let (mut row, mut largest) = (0, 0);
        for (goal, own) in evaluator.tuning.goals.iter().enumerate() {
            let t = (own.kind == GoalKind::Minimax).then_some(largest);
            for at in &own.rows {
                let [least, most] = at.wanted;
                let both = [(-1.0, least), (1.0, most)].into_iter();
                let held =
                    both.filter(|(_, bound)| own.kind != GoalKind::Squares && bound.is_finite());
                constraints.extend(held.map(|(sign, bound)| Constraint {
                    row,
                    goal,
                    sign,
                    bound,
                    largest: t,
                }));
                row += 1;
            }
            largest += usize::from(t.is_some());
        }
        let most = evaluator.tuning.target.evaluations;
        Self {
            multipliers: vec![0.0; constraints.len()],
            penalty: FIRST_PENALTY,
            constraints,
            evaluations: 0,
            most,
            kept: Vec::new(),
            largest,
            evaluator,
            watch,
            is_stopped: false,
        }
    }

    /// Returns the number of coordinates of the deck's unknowns.
    pub(crate) fn count(&self) -> usize {
        self.evaluator.tuning.unknowns.len()
    }

    /// Returns the evaluation at coordinates of the deck's unknowns. The last two evaluations are cached, because each round of multipliers
    /// starts at the end of the previous round.
    pub(crate) fn at(&mut self, x: &[f64]) -> Option<&Evaluation> {
        if let Some(k) = self.kept.iter().position(|kept| kept.x == x) {
            let found = self.kept.remove(k);
            self.kept.push(found);
        } else {
            if self.evaluations >= self.most || self.is_stopped {
                return None;
            }
            self.evaluations += 1;
            self.is_stopped = !(self.watch)(self.evaluations);
            let found = self.evaluator.evaluate(x, true)?;
            self.kept.push(found);
            if self.kept.len() > 2 {
                self.kept.remove(0);
            }
        }
        self.kept.last()
    }

    /// Returns the values of all constraints, given an evaluation and the largest misses of the minimax goals.
    pub(crate) fn constraint_values(&self, at: &Evaluation, largest: &[f64]) -> Vec<f64> {
        let goals = &self.evaluator.tuning.goals;
        let of = |own: &Constraint| {
            let miss = own.sign * (at.values[own.row] - own.bound) + at.widening(own.row);
            miss / goals[own.goal].tolerance - own.largest.map_or(0.0, |k| largest[k])
        };
        self.constraints.iter().map(of).collect()
    }

    /// Returns the largest miss of each minimax goal, in units of its tolerance.
    pub(crate) fn largest_misses(&self, at: &Evaluation) -> Vec<f64> {
        let mut found = vec![0.0; self.largest];
        let none = vec![0.0; self.largest];
        for (own, value) in self
            .constraints
            .iter()
            .zip(self.constraint_values(at, &none))
        {
            if let Some(k) = own.largest {
                found[k] = f64::max(found[k], value);
            }
        }
        found
    }

    /// Returns the priors of all coordinates. For the deck's unknowns, they are the cost of moves; for each largest miss, they are the cost
    /// of its minimax goal.
    pub(crate) fn priors(&self) -> Vec<Prior> {
        let unknowns = &self.evaluator.tuning.unknowns;
        let own = unknowns.iter().map(|unknown| Prior {
            mean: unknown.mean,
            sd: unknown.sd,
        });
        let goals = self.evaluator.tuning.goals.iter();
        let largest = goals
            .filter(|goal| goal.kind == GoalKind::Minimax)
            .map(|goal| Prior {
                mean: 0.0,
                sd: 1.0 / goal.weight.sqrt(),
            });
        own.chain(largest).collect()
    }
}

impl LeastSquares for Problem<'_, '_> {
    fn evaluate(&mut self, x: &[f64], with_jacobian: bool) -> Option<Residuals> {
        let count = self.count();
        let (own, largest) = x.split_at(count);
        self.at(own)?;
        let found = self.kept.last()?;
        let goals = &self.evaluator.tuning.goals;
        let constrained = self.constraint_values(found, largest);
        let squares = goals.iter().filter(|goal| goal.kind == GoalKind::Squares);
        let each = 1 + usize::from(found.spread.is_some());
        let height = each * squares.map(|goal| goal.rows.len()).sum::<usize>() + constrained.len();
        let mut residual = DVector::zeros(height);
        let mut jacobian = DMatrix::zeros(height, if with_jacobian { x.len() } else { 0 });
        let (mut at, mut row) = (0, 0);
        // A row of the Jacobian is a combination of the derivatives of a value and of its widening.
        let mut fill = |at: usize, row: usize, [value, widening]: [f64; 2]| {
            if with_jacobian {
                let mut sum = found.jacobian.row(row) * value;
                if widening != 0.0 {
                    sum += found.widening_change(row) * widening;
                }
                jacobian.view_mut((at, 0), (1, count)).copy_from(&sum);
            }
        };
        for goal in goals {
            let factor = (goal.weight / goal.rows.len() as f64).sqrt() / goal.tolerance;
            for own in &goal.rows {
                if goal.kind == GoalKind::Squares {
                    residual[at] = factor * own.miss(found.values[row]);
                    fill(at, row, [factor, 0.0]);
                    at += 1;
                    if found.spread.is_some() {
                        residual[at] = factor * found.widening(row);
                        fill(at, row, [0.0, factor]);
                        at += 1;
                    }
                }
                row += 1;
            }
        }
        let root = self.penalty.sqrt();
        let mut pulls = Vec::new();
        for ((own, value), multiplier) in self
            .constraints
            .iter()
            .zip(constrained)
            .zip(&self.multipliers)
        {
            let shifted = value + multiplier / self.penalty;
            if shifted > 0.0 {
                residual[at] = root * shifted;
                let factor = root / goals[own.goal].tolerance;
                fill(at, own.row, [factor * own.sign, factor]);
                pulls.extend(own.largest.map(|k| (at, count + k)));
            }
            at += 1;
        }
        if with_jacobian {
            for (at, column) in pulls {
                jacobian[(at, column)] = -root;
            }
        }
        Some(Residuals {
            residual,
            jacobian,
            free: Vec::new(),
        })
    }

    fn bounds(&self, x: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let unknowns = self.evaluator.tuning.unknowns.iter();
        let bounds = unknowns.map(|unknown| unknown.bounds);
        let largest = std::iter::repeat_n([0.0, f64::INFINITY], self.largest);
        let all = bounds.chain(largest).zip(x);
        Some(all.map(|([least, most], x)| (least - x, most - x)).unzip())
    }

    fn progress(&mut self, _: usize, _: &[f64], _: f64) -> bool {
        self.evaluations < self.most && !self.is_stopped
    }
}
