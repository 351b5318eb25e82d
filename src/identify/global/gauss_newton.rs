//! Gauss-Newton minimiser with a trust region, for whitened residuals and Gaussian priors.
//!
//! This module is independent of decks and marks: a problem is a function that returns residuals and their derivatives.

use nalgebra::{DMatrix, DVector};

use super::observation::Evaluation;
use crate::bounded;
use crate::settings::{
    CONVERGED_DECREMENT_NATS, CONVERGED_STEP, CURVATURE_RATIO_HIGH, CURVATURE_RATIO_LOW,
    FAR_FIT_RMS_SIGMA, HOMOTOPY_DECREMENT_NATS, HOMOTOPY_MAX_STAGES, HOMOTOPY_MAX_STEPS,
    HOMOTOPY_STALL_RATIO, HOMOTOPY_STEP, LATE_STEP_NATS, LATE_STEP_REMAINDER, MAX_LATE_RETRIES,
    MAX_STEPS_AFTER_UPHILL, MAX_TRIAL_STEPS, MAX_TRUST_REGION, MIN_TRUST_REGION,
    TRUST_REGION_SHRINKAGE,
};

/// A least-squares problem with Gaussian priors: minimise `1/2 |r(x)|^2 + 1/2 sum ((x - mean)/sd)^2` over `x`.
pub trait LeastSquares {
    /// Evaluates the residuals at `x` and, on request, the Jacobian. Returns `None` if the model has no solution there.
    fn evaluate(&mut self, x: &[f64], with_jacobian: bool) -> Option<Evaluation>;

    /// Stores the solver state of the last evaluation as the starting point of later evaluations.
    fn checkpoint(&mut self) {}

    /// Restores the solver state of the last checkpoint for the next evaluation. A rejected trial step may have reached a different
    /// equilibrium.
    fn rollback(&mut self) {}

    /// Returns the weight of each residual, given all residuals; 1 for a Gaussian likelihood.
    fn weights(&self, residual: &DVector<f64>) -> DVector<f64> {
        DVector::from_element(residual.len(), 1.0)
    }

    /// Returns the unknowns after a step from `x` in the step coordinates, in which the model is nearly linear.
    fn retract(&self, x: &[f64], step: &DVector<f64>) -> Vec<f64> {
        x.iter().zip(step.iter()).map(|(x, s)| x + s).collect()
    }

    /// Returns the step that leads from the unknowns `from` to the unknowns `to`, the inverse of [`Self::retract`].
    fn step_to(&self, from: &[f64], to: &[f64]) -> DVector<f64> {
        DVector::from_iterator(from.len(), to.iter().zip(from).map(|(to, from)| to - from))
    }

    /// Returns the lower and upper bounds of a step with which no unknown moves by more than `reach` natural units. `scale` is the natural unit
    /// of each unknown.
    fn limits(&self, scale: &[f64], reach: f64) -> (Vec<f64>, Vec<f64>) {
        let upper: Vec<f64> = scale.iter().map(|scale| reach * scale).collect();
        (upper.iter().map(|u| -u).collect(), upper)
    }

    /// Returns the lower and upper bounds of a step from `x`, from bounds of the unknowns themselves, in step coordinates. `None` without
    /// bounds.
    fn bounds(&self, _x: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        None
    }

    /// Receives the state after an accepted step: the number of accepted steps, the unknowns and the objective. Returns `false` to stop the
    /// fit.
    fn progress(&mut self, _iteration: usize, _x: &[f64], _objective: f64) -> bool {
        true
    }
}

/// Gaussian prior of one unknown.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Prior {
    /// Mean of the prior.
    pub mean: f64,
    /// Prior standard deviation. It is infinite without a prior, and zero for a held unknown.
    pub sd: f64,
}

impl Prior {
    /// Returns true if the prior contributes to the objective. It does not if its standard deviation is infinite (no prior) or zero (held
    /// unknown).
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

    /// Returns the derivative of the prior term of the objective at `x`.
    pub fn pull(self, x: f64) -> f64 {
        if self.has_width() {
            (x - self.mean) / (self.sd * self.sd)
        } else {
            0.0
        }
    }

    /// Returns the prior term of the objective at `x`.
    pub fn cost(self, x: f64) -> f64 {
        0.5 * self.pull(x) * (x - self.mean)
    }
}

/// Termination criteria of a fit.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Tolerances {
    /// Predicted decrease of the objective by the next step (Newton decrement) below which the fit has converged.
    pub decrement: f64,
    /// Step size below which the fit has converged: the largest change of any unknown, in units of its scale.
    pub step: f64,
    /// Maximum number of trial steps, including rejected steps.
    pub max_iterations: usize,
}

impl Default for Tolerances {
    fn default() -> Self {
        Self {
            decrement: CONVERGED_DECREMENT_NATS,
            step: CONVERGED_STEP,
            max_iterations: MAX_TRIAL_STEPS,
        }
    }
}

/// Reason why a fit ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Ending {
    /// A convergence criterion was met.
    Converged,
    /// The maximum number of trial steps was reached.
    MaxIterations,
    /// No step reduces the objective, although no convergence criterion is met.
    Stalled,
    /// The caller stopped the fit.
    Stopped,
    /// The model has no solution at the starting values.
    NoAnswer,
}

/// Final state of a minimisation.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// Values of the unknowns at the end of the fit.
    pub x: Vec<f64>,
    /// Objective at `x`.
    pub objective: f64,
    /// Residuals and Jacobian at `x`.
    pub evaluation: Evaluation,
    /// Weights of the residuals at `x`.
    pub weights: DVector<f64>,
    /// Information matrix of readings and priors: `J^T W J` plus the inverse prior variances.
    pub information: DMatrix<f64>,
    /// Predicted decrease of the objective by one more step.
    pub decrement: f64,
    /// Number of accepted steps.
    pub iterations: usize,
    /// Reason why the minimisation ended.
    pub ending: Ending,
}

/// Secant estimate of the second-order term `sum r_i H_i` of the Hessian, which the Gauss-Newton method neglects.
///
/// Along poorly determined directions, this term can be as large as the information matrix, and Gauss-Newton steps then overshoot and
/// oscillate. The observed change of the objective along a step reveals the missing curvature. The curvature is attributed to the unknowns that
/// moved most in natural units. Source: secant updates of NL2SOL (Dennis, Gay and Welsch, 1981), reduced to a positive semidefinite correction.
struct SecantCorrection(DMatrix<f64>);

impl SecantCorrection {
    /// Updates the correction after a step. `slope` and `bend` are the slope and curvature of the quadratic model along the step, `rise` is the
    /// observed change of the objective.
    fn update(&mut self, step: &DVector<f64>, scale: &[f64], (slope, bend): (f64, f64), rise: f64) {
        let seen = 2.0 * (rise - slope);
        if !(seen / bend).is_finite() {
            return;
        }
        if seen > CURVATURE_RATIO_HIGH * bend {
            let blame = DVector::from_fn(step.len(), |k, _| step[k] / (scale[k] * scale[k]));
            let size = blame.dot(step);
            self.0 += &blame * blame.transpose() * ((seen - bend) / (size * size));
        } else if seen < CURVATURE_RATIO_LOW * bend {
            self.0 *= 0.5;
        }
    }
}

/// An iterate of the minimiser: unknowns, residuals, weights, objective, information matrix and gradient.
struct Iterate {
    x: Vec<f64>,
    evaluation: Evaluation,
    weights: DVector<f64>,
    value: f64,
    information: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl Iterate {
    /// Returns the step within the bounds that minimises the quadratic model of the objective, and its predicted decrease. `missing` is added
    /// to the Hessian of the model if given.
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

/// Returns the objective: half the weighted sum of squared residuals plus the prior terms.
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

/// Returns the information matrix, `J^T W J` plus the inverse prior variances, and the gradient of the objective.
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
    // This product is blocked and about five times as fast as `tr_mul`.
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

/// Returns the bounds of a step from `x`: those of [`LeastSquares::limits`], tightened by those of [`LeastSquares::bounds`].
fn within(
    problem: &dyn LeastSquares,
    x: &[f64],
    scale: &[f64],
    reach: f64,
) -> (Vec<f64>, Vec<f64>) {
    let (mut lower, mut upper) = problem.limits(scale, reach);
    if let Some((least, most)) = problem.bounds(x) {
        for k in 0..x.len() {
            lower[k] = lower[k].max(least[k].min(0.0));
            upper[k] = upper[k].min(most[k].max(0.0));
        }
    }
    (lower, upper)
}

/// Minimises the objective of a least-squares problem from `start`. `scale` is the natural unit of each unknown. Unknowns marked in `held` stay
/// fixed.
///
/// Each step minimises the quadratic model within a box whose sides are multiples of the natural units. A poorly determined unknown therefore
/// does not restrict the steps of the others. Near the minimum, the second-order curvature is estimated from the steps, see `SecantCorrection`.
///
/// After a step that increases the objective, up to three further steps are tried before all of them are rejected (watchdog technique of
/// Chamberlain, Powell and others, 1982). In a narrow curved valley of the objective, a long step climbs the wall, and the next step returns to
/// the floor further along. Short steps would progress slowly there.
///
/// Returns `None` only if the model has no solution at the start.
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
        Iterate {
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
    let mut reach = MAX_TRUST_REGION;
    let mut missing = SecantCorrection(DMatrix::zeros(start.len(), start.len()));
    let mut retries = 0;
    let (mut iterations, mut tries, mut ending) = (0, 0, Ending::MaxIterations);
    'steps: while tries < tolerances.max_iterations {
        let mut uphill: Option<Iterate> = None;
        let (mut first, mut promised) = (reach, 0.0);
        for chance in 0..=MAX_STEPS_AFTER_UPHILL {
            let at = uphill.as_ref().unwrap_or(&best);
            let learnt = (chance == 0).then_some(&missing);
            let (step, gain) = at.step(learnt, &within(problem, &at.x, scale, reach), held);
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
            let remains = best.value - promised > LATE_STEP_REMAINDER * best.value;
            let late = chance == 0 && promised < LATE_STEP_NATS && remains;
            if late {
                let slope = best.gradient.dot(&step);
                let model = (slope, -2.0 * (promised + slope));
                missing.update(&step, scale, model, -gained);
            } else if chance == 0 {
                missing.0.fill(0.0);
            }
            if late && gained <= 0.0 && retries < MAX_LATE_RETRIES {
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
                reach = reach.max(2.0 * first).min(MAX_TRUST_REGION);
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
        reach = TRUST_REGION_SHRINKAGE * reach.min(first);
        if reach < MIN_TRUST_REGION {
            // Round-off hides any further decrease. If the predicted decrease is small as well, the fit has converged.
            let (_, left) = best.step(
                Some(&missing),
                &within(problem, &best.x, scale, MAX_TRUST_REGION),
                held,
            );
            ending = if left <= 1e-3 {
                Ending::Converged
            } else {
                Ending::Stalled
            };
            break;
        }
    }
    let (_, decrement) = best.step(
        Some(&missing),
        &within(problem, &best.x, scale, MAX_TRUST_REGION),
        held,
    );
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

/// Returns a starting point for a fit whose initial residuals are much larger than the noise.
///
/// Far from the solution, the linear model overstates the information of the readings, so poorly determined unknowns would diverge by orders of
/// magnitude. Each stage therefore takes the current rms residual as the noise level. Every unknown gets a prior centred at `start` with a
/// standard deviation of one natural unit. As the residuals fall from stage to stage, the readings gain weight. Source: Levenberg damping
/// proportional to the squared residual (Yamashita and Fukushima, 2001).
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
    for _ in 0..HOMOTOPY_MAX_STAGES {
        let Some(here) = problem.evaluate(&x, false) else {
            return x;
        };
        let misfit = (here.residual.norm_squared() / here.residual.len().max(1) as f64).sqrt();
        if !(misfit > FAR_FIT_RMS_SIGMA && misfit < HOMOTOPY_STALL_RATIO * before) {
            return x;
        }
        before = misfit;
        let mut louder = InflatedNoise {
            problem: &mut *problem,
            noise: misfit,
        };
        let tolerances = Tolerances {
            decrement: HOMOTOPY_DECREMENT_NATS,
            step: HOMOTOPY_STEP,
            max_iterations: HOMOTOPY_MAX_STEPS,
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

/// A least-squares problem with the noise multiplied by `noise`, so all residuals are divided by it.
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

    fn bounds(&self, x: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        self.problem.bounds(x)
    }

    fn progress(&mut self, iteration: usize, x: &[f64], objective: f64) -> bool {
        self.problem.progress(iteration, x, objective)
    }
}

/// Returns the largest change of an unknown between two sets of unknowns, in natural units.
fn longest(from: &[f64], to: &[f64], scale: &[f64]) -> f64 {
    from.iter()
        .zip(to)
        .zip(scale)
        .map(|((from, to), scale)| ((to - from) / scale).abs())
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
