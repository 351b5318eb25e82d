//! Gauss-Newton with a trust region on whitened residuals with Gaussian priors.
//!
//! Knows neither decks nor marks: only a function that gives residuals and their derivatives.

use nalgebra::{DMatrix, DVector};

use super::observation::Evaluation;
use crate::bounded;

/// A sum of squares to minimise: `1/2 |r(x)|^2 + 1/2 sum ((x - mean)/sd)^2`.
pub trait LeastSquares {
    /// Residuals, with the Jacobian when asked for. `None` where the model has no answer.
    fn evaluate(&mut self, x: &[f64], with_jacobian: bool) -> Option<Evaluation>;

    /// Remembers what the last evaluation ended with, for the next ones to begin there.
    fn checkpoint(&mut self) {}

    /// Lets the next evaluation begin with what was remembered last: that of a trial may be of another equilibrium.
    fn rollback(&mut self) {}

    /// Weight of each residual at these residuals; 1 for a Gaussian likelihood.
    fn weights(&self, residual: &DVector<f64>) -> DVector<f64> {
        DVector::from_element(residual.len(), 1.0)
    }

    /// Where a step of the linear model leads.
    fn retract(&self, x: &[f64], step: &DVector<f64>) -> Vec<f64> {
        x.iter().zip(step.iter()).map(|(x, s)| x + s).collect()
    }

    /// The step that leads from one place to another.
    fn step_to(&self, from: &[f64], to: &[f64]) -> DVector<f64> {
        DVector::from_iterator(from.len(), to.iter().zip(from).map(|(to, from)| to - from))
    }

    /// Lower and upper bound of a step that moves no unknown by more than `reach` natural units.
    fn limits(&self, scale: &[f64], reach: f64) -> (Vec<f64>, Vec<f64>) {
        let upper: Vec<f64> = scale.iter().map(|scale| reach * scale).collect();
        (upper.iter().map(|u| -u).collect(), upper)
    }

    /// Called after every accepted step with its number, x and the objective. `false` stops the fit there.
    fn progress(&mut self, _iteration: usize, _x: &[f64], _objective: f64) -> bool {
        true
    }
}

/// Prior of one unknown.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Prior {
    /// Mean.
    pub mean: f64,
    /// Standard deviation; infinite for none.
    pub sd: f64,
}

impl Prior {
    /// False for what is free, and for what is held: that has no share in the objective.
    fn has_width(self) -> bool {
        self.sd.is_finite() && self.sd > 0.0
    }

    fn information(self) -> f64 {
        if self.has_width() {
            1.0 / (self.sd * self.sd)
        } else {
            0.0
        }
    }

    /// Slope of its share of the objective.
    pub fn pull(self, x: f64) -> f64 {
        if self.has_width() {
            (x - self.mean) / (self.sd * self.sd)
        } else {
            0.0
        }
    }

    /// Its share of the objective.
    pub fn cost(self, x: f64) -> f64 {
        0.5 * self.pull(x) * (x - self.mean)
    }
}

/// When to stop.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Tolerances {
    /// Newton decrement: the objective the next step would still gain.
    pub decrement: f64,
    /// Largest step of any unknown, in units of its scale.
    pub step: f64,
    /// Steps tried at most, rejected ones included.
    pub max_iterations: usize,
}

impl Default for Tolerances {
    fn default() -> Self {
        Self {
            // The next step would move nothing by more than a hundredth of its standard deviation.
            decrement: 1e-4,
            // Convergence is quadratic near the end: after a step of a millionth nothing worth a sweep is left.
            step: 1e-6,
            max_iterations: 100,
        }
    }
}

/// Why a fit ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Ending {
    /// A tolerance was met.
    Converged,
    /// Out of iterations.
    MaxIterations,
    /// No step lowers the objective any more although the tolerances are not met.
    Stalled,
    /// The caller asked to stop.
    Stopped,
    /// The model has no answer where the fit starts.
    NoAnswer,
}

/// The end of a fit.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// Unknowns.
    pub x: Vec<f64>,
    /// Objective there.
    pub objective: f64,
    /// Residuals and Jacobian there.
    pub evaluation: Evaluation,
    /// Weights there.
    pub weights: DVector<f64>,
    /// Information of the data plus that of the priors.
    pub information: DMatrix<f64>,
    /// What the objective would still gain by one more step.
    pub decrement: f64,
    /// Accepted steps.
    pub iterations: usize,
    /// Why it ended.
    pub ending: Ending,
}

/// A step moves no unknown by more natural units than this: one and a half e-folds of a stiffness.
const REACH: f64 = 1.5;
/// The reach shrinks by this after steps that led nowhere.
const SHRINK: f64 = 0.3;
/// Steps shorter than this are lost in round-off.
const LEAST_REACH: f64 = 1e-9;
/// So often a step that led uphill is followed further before it is given up.
const CHANCES: usize = 3;

/// A step that promises less than this is near the end: the objective is half a chi-square, so all its unknowns together move by
/// two standard deviations.
const LATE: f64 = 2.0;
/// ... and only if it leaves most of the objective: residuals that vanish take their curvature with them.
const REMAINS: f64 = 0.9;
/// So often a late step is tried again with what the last one taught before the reach is shortened.
const RETRIES: usize = 6;

/// Curvature of the residuals themselves, which the linear model leaves out.
///
/// Times the noise it is as large as the information along directions that the data hardly determine: there the linear model's
/// steps overshoot, and go on overshooting from one side to the other. What a step really did along itself tells how much is
/// missing; it is blamed on the unknowns that moved most in natural units. (The secants of Dennis, Gay and Welsch's NL2SOL, 1981,
/// reduced to what keeps the model positive.)
struct SecantCorrection(DMatrix<f64>);

/// What a step did over what the model said of its curvature: beyond these more is missing, or less.
const MISJUDGED: (f64, f64) = (0.7, 1.1);

impl SecantCorrection {
    /// After a step with this slope and curvature in the model, and the rise it really made.
    fn update(&mut self, step: &DVector<f64>, scale: &[f64], (slope, bend): (f64, f64), rise: f64) {
        let seen = 2.0 * (rise - slope);
        if !(seen / bend).is_finite() {
            return;
        }
        if seen > MISJUDGED.1 * bend {
            let blame = DVector::from_fn(step.len(), |k, _| step[k] / (scale[k] * scale[k]));
            let size = blame.dot(step);
            self.0 += &blame * blame.transpose() * ((seen - bend) / (size * size));
        } else if seen < MISJUDGED.0 * bend {
            self.0 *= 0.5;
        }
    }
}

/// Where a fit stands.
struct Point {
    x: Vec<f64>,
    evaluation: Evaluation,
    weights: DVector<f64>,
    value: f64,
    information: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl Point {
    /// The step of the linear model within limits, and what it would gain.
    fn step(
        &self,
        missing: Option<&SecantCorrection>,
        (lower, upper): &(Vec<f64>, Vec<f64>),
        held: &[bool],
    ) -> (DVector<f64>, f64) {
        let mut information = match missing {
            Some(missing) => &self.information + &missing.0,
            None => self.information.clone(),
        };
        let mut right = -&self.gradient;
        for (k, held) in held.iter().enumerate() {
            if *held {
                information.fill_row(k, 0.0);
                information.fill_column(k, 0.0);
                information[(k, k)] = 1.0;
                right[k] = 0.0;
            }
        }
        let (step, _) = bounded::solve(&information, &right, lower, upper);
        let gain = step.dot(&right) - 0.5 * step.dot(&(&information * &step));
        (step, gain)
    }
}

/// Objective of weighted residuals and priors.
pub(super) fn objective(
    evaluation: &Evaluation,
    weights: &DVector<f64>,
    x: &[f64],
    priors: &[Prior],
) -> f64 {
    let data: f64 = evaluation
        .residual
        .iter()
        .zip(weights)
        .map(|(r, w)| 0.5 * w * r * r)
        .sum();
    data + x
        .iter()
        .zip(priors)
        .map(|(x, prior)| prior.cost(*x))
        .sum::<f64>()
}

/// `J^T W J` plus the information of the priors, and the gradient.
fn normal_equations(
    evaluation: &Evaluation,
    weights: &DVector<f64>,
    x: &[f64],
    priors: &[Prior],
) -> (DMatrix<f64>, DVector<f64>) {
    let mut weighted = evaluation.jacobian.clone();
    for (mut row, w) in weighted.row_iter_mut().zip(weights) {
        row *= w.sqrt();
    }
    // A product by blocks; `tr_mul` takes five times as long.
    let mut information = weighted.transpose() * &weighted;
    let mut gradient = evaluation
        .jacobian
        .tr_mul(&evaluation.residual.component_mul(weights));
    for (k, prior) in priors.iter().enumerate() {
        information[(k, k)] += prior.information();
        gradient[k] += prior.pull(x[k]);
    }
    (information, gradient)
}

/// Minimises from `start`. `scale` is the size of a natural step of each unknown; `held` unknowns stay where they are.
///
/// Each step minimises the linear model within a box of natural units, so that what little the data say of one unknown does not
/// hold back the others. Near the end the curvature of the residuals is learnt from the steps, see `SecantCorrection`. A step that leads
/// uphill is followed a few times more before it is given up (the watchdog of Chamberlain, Powell and others, 1982): a long step
/// along a narrow curved valley climbs its wall, the next one falls to its floor further on; a shorter first step would crawl. `None` only if the model has no answer at the start.
pub fn minimise(
    problem: &mut dyn LeastSquares,
    start: &[f64],
    priors: &[Prior],
    scale: &[f64],
    held: &[bool],
    tolerances: Tolerances,
) -> Option<Minimum> {
    let point = |problem: &dyn LeastSquares, x: Vec<f64>, evaluation: Evaluation| {
        let weights = problem.weights(&evaluation.residual);
        let value = objective(&evaluation, &weights, &x, priors);
        let (information, gradient) = normal_equations(&evaluation, &weights, &x, priors);
        Point {
            x,
            evaluation,
            weights,
            value,
            information,
            gradient,
        }
    };
    let evaluation = problem.evaluate(start, true)?;
    problem.checkpoint();
    let mut best = point(problem, start.to_vec(), evaluation);
    let mut reach = REACH;
    let mut missing = SecantCorrection(DMatrix::zeros(start.len(), start.len()));
    let mut retries = 0;
    let (mut iterations, mut tries, mut ending) = (0, 0, Ending::MaxIterations);
    'steps: while tries < tolerances.max_iterations {
        let mut uphill: Option<Point> = None;
        let (mut first, mut promised) = (reach, 0.0);
        for chance in 0..=CHANCES {
            let at = uphill.as_ref().unwrap_or(&best);
            let learnt = (chance == 0).then_some(&missing);
            let (step, gain) = at.step(learnt, &problem.limits(scale, reach), held);
            let trial = problem.retract(&at.x, &step);
            if chance == 0 {
                (first, promised) = (longest(&at.x, &trial, scale), gain);
                let free = first < 0.5 * reach;
                if gain <= tolerances.decrement || (free && first <= tolerances.step) {
                    ending = Ending::Converged;
                    break 'steps;
                }
            }
            tries += 1;
            let Some(evaluation) = problem.evaluate(&trial, true) else {
                break;
            };
            let next = point(problem, trial, evaluation);
            let gained = best.value - next.value;
            if !gained.is_finite() {
                break;
            }
            let remains = best.value - promised > REMAINS * best.value;
            let late = chance == 0 && promised < LATE && remains;
            if late {
                let slope = best.gradient.dot(&step);
                let model = (slope, -2.0 * (promised + slope));
                missing.update(&step, scale, model, -gained);
            } else if chance == 0 {
                missing.0.fill(0.0);
            }
            if late && gained <= 0.0 && retries < RETRIES {
                retries += 1;
                problem.rollback();
                continue 'steps;
            }
            if gained <= 0.0 {
                uphill = Some(next);
                continue;
            }
            let kept = gained / promised;
            if chance == 0 && kept > 0.5 {
                reach = reach.max(2.0 * first).min(REACH);
            } else if kept < 0.1 {
                reach = 0.5 * first;
            }
            best = next;
            problem.checkpoint();
            retries = 0;
            iterations += 1;
            if !problem.progress(iterations, &best.x, best.value) {
                ending = Ending::Stopped;
                break 'steps;
            }
            continue 'steps;
        }
        problem.rollback();
        reach = SHRINK * reach.min(first);
        if reach < LEAST_REACH {
            // Round-off hides any further gain: at a minimum this is convergence.
            let (_, left) = best.step(Some(&missing), &problem.limits(scale, REACH), held);
            ending = if left <= 1e-3 {
                Ending::Converged
            } else {
                Ending::Stalled
            };
            break;
        }
    }
    let (_, decrement) = best.step(Some(&missing), &problem.limits(scale, REACH), held);
    Some(Minimum {
        x: best.x,
        objective: best.value,
        evaluation: best.evaluation,
        weights: best.weights,
        information: best.information,
        decrement,
        iterations,
        ending,
    })
}

/// A stage of [`approach`] takes so many steps at most, and there are so many stages.
const STEPS_OF_A_STAGE: usize = 8;
const STAGES: usize = 12;
/// A stage that leaves more than this of the misfit was the last one.
const STALLED: f64 = 0.8;
/// Louder noise than this hides how far away the answer is.
pub(crate) const LOUD: f64 = 3.0;

/// A place from which a fit goes on well, for starts that miss the readings by much more than their noise.
///
/// Far away the readings seem to say more than they do: what they hardly determine would run off by orders of magnitude after what the
/// linear model misses, and not come back. So the noise counts as the misfit there is, and every unknown has a prior of one natural unit
/// about the start; stage by stage the misfit falls and the readings count more. (Levenberg's damping by the square of the misfit, as of
/// Yamashita and Fukushima, 2001.)
pub fn homotopy_start(
    problem: &mut dyn LeastSquares,
    start: &[f64],
    scale: &[f64],
    held: &[bool],
) -> Vec<f64> {
    let priors: Vec<Prior> = start
        .iter()
        .zip(scale)
        .map(|(start, scale)| Prior {
            mean: *start,
            sd: *scale,
        })
        .collect();
    let mut x = start.to_vec();
    let mut before = f64::INFINITY;
    for _ in 0..STAGES {
        let Some(here) = problem.evaluate(&x, false) else {
            return x;
        };
        let misfit = (here.residual.norm_squared() / here.residual.len().max(1) as f64).sqrt();
        if !(misfit > LOUD && misfit < STALLED * before) {
            return x;
        }
        before = misfit;
        let mut louder = InflatedNoise {
            problem: &mut *problem,
            noise: misfit,
        };
        let tolerances = Tolerances {
            decrement: 0.1,
            step: 1e-2,
            max_iterations: STEPS_OF_A_STAGE,
        };
        let Some(found) = minimise(&mut louder, &x, &priors, scale, held, tolerances) else {
            return x;
        };
        x = found.x;
        if found.ending == Ending::Stopped {
            return x;
        }
    }
    x
}

/// A problem whose noise is so many times as large.
struct InflatedNoise<'a> {
    problem: &'a mut dyn LeastSquares,
    noise: f64,
}

impl LeastSquares for InflatedNoise<'_> {
    fn evaluate(&mut self, x: &[f64], with_jacobian: bool) -> Option<Evaluation> {
        let found = self.problem.evaluate(x, with_jacobian)?;
        Some(Evaluation {
            residual: found.residual / self.noise,
            jacobian: found.jacobian / self.noise,
            free: found.free,
        })
    }

    fn checkpoint(&mut self) {
        self.problem.checkpoint();
    }

    fn rollback(&mut self) {
        self.problem.rollback();
    }

    fn retract(&self, x: &[f64], step: &DVector<f64>) -> Vec<f64> {
        self.problem.retract(x, step)
    }

    fn step_to(&self, from: &[f64], to: &[f64]) -> DVector<f64> {
        self.problem.step_to(from, to)
    }

    fn limits(&self, scale: &[f64], reach: f64) -> (Vec<f64>, Vec<f64>) {
        self.problem.limits(scale, reach)
    }

    fn progress(&mut self, iteration: usize, x: &[f64], objective: f64) -> bool {
        self.problem.progress(iteration, x, objective)
    }
}

/// The largest displacement between two places, in natural units.
fn longest(from: &[f64], to: &[f64], scale: &[f64]) -> f64 {
    from.iter()
        .zip(to)
        .zip(scale)
        .map(|((from, to), scale)| ((to - from) / scale).abs())
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
