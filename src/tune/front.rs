//! Pareto front of two goals: the trade-off between them.

use crate::cost::goal_size;
use crate::descent::search_from;
use crate::evaluation::Evaluator;
use crate::found::Found;
use crate::goal::GoalKind;
use crate::settings::{FRONT_END_WEIGHT, FRONT_POINTS, FRONT_SLACK, FRONT_SPACING, LIMIT_SLACK};
use crate::tuning::Tuning;
use serde::Serialize;

/// Pareto front of two goals: points within the bounds at which one goal cannot be improved without making the other worse. All other
/// goals, the limits and the cost of moves count as in the search.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Front {
    /// Names of the goals.
    pub goals: [String; 2],
    /// Units of the misses of the goals.
    pub units: [String; 2],
    /// Measure of the misses of each goal: `rms` or `largest`.
    pub measures: [&'static str; 2],
    /// Tolerances of the goals, in their units.
    pub tolerances: [f64; 2],
    /// Misses of the two goals in the tuned deck.
    pub tuned: [f64; 2],
    /// Points in ascending order of the first goal's miss.
    pub points: Vec<FrontPoint>,
    /// Number of evaluations with derivatives.
    pub evaluations: usize,
}

/// A point of a Pareto front.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct FrontPoint {
    /// Misses of the two goals: the root mean square over the rows, or the largest miss of a minimax goal or limit. In a robust target, they
    /// include two standard deviations of the values due to the tolerances.
    pub misses: [f64; 2],
    /// Weights of the two goals in the search for this point.
    pub weights: [f64; 2],
    /// Values of the unknowns, in the order of the unknowns.
    pub values: Vec<f64>,
    /// True if all limits among the other goals hold.
    pub keeps_limits: bool,
    /// True if the search converged.
    pub converged: bool,
}

/// Result of a search with given weights of the two goals.
struct Tried {
    /// Natural logarithm of the ratio of the first goal's weight to the second goal's weight.
    ratio: f64,
    x: Vec<f64>,
    point: FrontPoint,
}

impl Tuning {
    /// Returns the Pareto front of the two goals with the indices `pair`. The first searches begin at the coordinates `x` of a solution.
    ///
    /// Each point minimises the cost with different weights of the two goals. The first two points are the ends of the front. Each further
    /// point is sought in the widest gap. For a limit, the largest miss is minimised.
    ///
    /// `watch` receives the numbers of points and of evaluations so far. It returns false to stop.
    ///
    /// # Panics
    /// If an index in `pair` is not the index of a goal.
    pub fn front(
        &self,
        x: &[f64],
        pair: [usize; 2],
        watch: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Front {
        let mut relaxed = self.clone();
        for k in pair {
            let goal = &mut relaxed.goals[k];
            if goal.kind == GoalKind::Limit {
                goal.kind = GoalKind::Minimax;
            }
        }
        let (mut evaluations, mut goes_on) = (0, true);
        let mut tried: Vec<Tried> = Vec::new();
        let mut tuned = [f64::NAN; 2];
        if let Some(at) = Evaluator::new(&relaxed).evaluate(x, false) {
            tuned = relaxed.sizes(pair, &at);
        }
        let end = libm::log(FRONT_END_WEIGHT);
        let mut next = Some((end, x.to_vec()));
        while let Some((ratio, start)) = next.take().filter(|_| goes_on) {
            let weights = [ratio, -ratio].map(|ln| libm::exp(ln.max(0.0)));
            for (k, weight) in pair.into_iter().zip(weights) {
                relaxed.goals[k].weight = weight;
            }
            let (count, before) = (tried.len(), evaluations);
            let mut tell = |done: usize| {
                goes_on = watch(count, before + done);
                goes_on
            };
            let mut evaluator = Evaluator::new(&relaxed);
            let found = search_from(&mut evaluator, &start, &mut tell);
            evaluations += found.evaluations;
            if let Some(point) = relaxed.point(pair, weights, &found) {
                tried.push(Tried {
                    ratio,
                    x: found.x,
                    point,
                });
                tried.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
            }
            next = match tried.len() {
                1 if ratio > 0.0 => Some((-end, x.to_vec())),
                0 | 1 => None,
                count if count < FRONT_POINTS => widest_gap(&tried),
                _ => None,
            };
        }
        let measure = |k: usize| match self.goals[k].kind {
            GoalKind::Squares => "rms",
            GoalKind::Minimax | GoalKind::Limit => "largest",
        };
        Front {
            goals: pair.map(|k| self.goals[k].name()),
            units: pair.map(|k| self.goals[k].unit.clone()),
            measures: pair.map(measure),
            tolerances: pair.map(|k| self.goals[k].tolerance),
            tuned,
            points: undominated(tried),
            evaluations,
        }
    }

    fn sizes(&self, pair: [usize; 2], at: &crate::evaluation::Evaluation) -> [f64; 2] {
        let all: Vec<f64> = self
            .ranges()
            .map(|(goal, rows)| goal_size(goal, rows, at))
            .collect();
        pair.map(|k| all[k])
    }

    fn point(&self, pair: [usize; 2], weights: [f64; 2], found: &Found) -> Option<FrontPoint> {
        let at = found.end.as_ref()?;
        let unknowns = self.unknowns.iter().zip(&found.x);
        Some(FrontPoint {
            misses: self.sizes(pair, at),
            weights,
            values: unknowns.map(|(unknown, x)| unknown.shown(*x)).collect(),
            keeps_limits: found.violation <= LIMIT_SLACK,
            converged: found.is_converged,
        })
    }
}

/// Returns the range of each of the two misses over all points. A range of zero is replaced by one.
fn extent(tried: &[Tried]) -> [f64; 2] {
    [0, 1].map(|k| {
        let each = tried.iter().map(|own| own.point.misses[k]);
        let (least, most) = each.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), miss| {
            (least.min(miss), most.max(miss))
        });
        if most > least { most - least } else { 1.0 }
    })
}

/// Returns the logarithmic weight ratio in the middle of the widest gap between neighbouring points, and the coordinates at which to begin.
/// Returns `None` if the gap is too small, or if no ratio lies between those of the neighbours.
fn widest_gap(tried: &[Tried]) -> Option<(f64, Vec<f64>)> {
    let size = extent(tried);
    let gap = |pair: &[Tried]| {
        let along = [0, 1].map(|k| (pair[1].point.misses[k] - pair[0].point.misses[k]) / size[k]);
        libm::hypot(along[0], along[1])
    };
    let pairs = tried.windows(2);
    let widest = pairs.max_by(|a, b| gap(a).total_cmp(&gap(b)))?;
    let ratio = 0.5 * (widest[0].ratio + widest[1].ratio);
    // If no weight lies between those of two neighbours, the front has a jump there.
    let is_apart = widest[0].ratio < ratio && ratio < widest[1].ratio;
    (gap(widest) > FRONT_SPACING && is_apart).then(|| (ratio, widest[0].x.clone()))
}

/// Returns the nondominated points, in ascending order of the first miss.
fn undominated(tried: Vec<Tried>) -> Vec<FrontPoint> {
    let slack = extent(&tried).map(|size| FRONT_SLACK * size);
    let mut points: Vec<FrontPoint> = tried.into_iter().map(|own| own.point).collect();
    points.sort_by(|a, b| {
        let [first, second] = [0, 1].map(|k| a.misses[k].total_cmp(&b.misses[k]));
        first.then(second)
    });
    let mut kept: Vec<FrontPoint> = Vec::new();
    for point in points {
        let is_better = |other: &FrontPoint| {
            other.keeps_limits >= point.keeps_limits
                && other.misses[1] <= point.misses[1] + slack[1]
        };
        if !kept.iter().any(is_better) {
            kept.push(point);
        }
    }
    kept
}
