//! Profile-likelihood intervals. The interval of an unknown ends where the objective, minimised over all other unknowns, has risen by 1.92
//! above its minimum.
//!
//! The path to the end of an interval uses the step coordinates of [`LeastSquares::retract`]. The model is nearly linear in these, so the
//! quadratic approximation is accurate over a longer range than in ln K.
//!
//! At the predicted end, the objective is evaluated once without derivatives. A constrained step with the Jacobian of the estimate would lower
//! the objective further; this predicted decrease is subtracted from the rise. If the decrease is not small, further steps follow with a
//! Jacobian corrected by Broyden's method (Broyden 1965). A fit with derivatives is made only if these steps do not converge.

use nalgebra::{DMatrix, DVector};

use super::gauss_newton::{LeastSquares, Minimum, Prior, Tolerances, minimise, objective};
use crate::bounded;
use crate::settings::{
    HALF_CHI_SQUARE_95, NORMAL_QUANTILE_975, PROFILE_DECREMENT_NATS, PROFILE_DIFFERENCE_STEP,
    PROFILE_FEW_EVALUATIONS, PROFILE_INTERPOLATION_NATS, PROFILE_MAX_EVALUATIONS,
    PROFILE_MAX_LN_DISTANCE, PROFILE_MAX_OTHER_STEP, PROFILE_MAX_POINTS, PROFILE_MAX_TRIAL_STEPS,
    PROFILE_STEP,
};

/// Computes the 95 percent profile-likelihood interval of unknown `k` around a minimum. `covariance` is the posterior covariance there.
///
/// The prior of unknown `k` itself is left out, so a side on which the readings set no bound is `None`. A profile point near the end that took
/// many evaluations is computed a second time, starting from the estimate. The lower of the two objectives is used.
pub fn profile_interval(
    problem: &mut dyn LeastSquares,
    minimum: &Minimum,
    k: usize,
    covariance: &DMatrix<f64>,
    priors: &[Prior],
    scale: &[f64],
    held: &[bool],
) -> [Option<f64>; 2] {
    let variance = covariance[(k, k)];
    if !(variance > 0.0) {
        return [Some(minimum.x[k]); 2];
    }
    let mut priors = priors.to_vec();
    priors[k].sd = f64::INFINITY;
    let mut held = held.to_vec();
    held[k] = true;
    let weight = |j: usize| {
        let variance = covariance[(j, j)];
        if variance > 0.0 { 1.0 / variance } else { 0.0 }
    };
    let count = minimum.x.len();
    let base = objective(&minimum.evaluation, &minimum.weights, &minimum.x, &priors);
    let mut profile = Profile {
        problem,
        minimum,
        k,
        along: covariance.column(k) / variance,
        metric: DVector::from_fn(count, |j, _| weight(j)),
        priors,
        scale,
        held,
        base,
    };
    [-1.0, 1.0].map(|direction| {
        let step = profile.side(direction, variance.sqrt())?;
        Some(profile.place(&profile.alone(step))[k])
    })
}

/// Profile of the objective over unknown `k`: its minimum over all other unknowns.
struct Profile<'a> {
    problem: &'a mut dyn LeastSquares,
    minimum: &'a Minimum,
    k: usize,
    /// Predicted step of each unknown per unit step of unknown `k`, from the covariance.
    along: DVector<f64>,
    /// Reciprocal posterior variance of each unknown.
    metric: DVector<f64>,
    priors: Vec<Prior>,
    scale: &'a [f64],
    held: Vec<bool>,
    /// Lowest objective found so far, without the prior of unknown `k`.
    base: f64,
}

/// Point of the profile: minimum of the objective for a given step of unknown `k`.
struct ProfilePoint {
    step: DVector<f64>,
    /// Objective at the point minus the predicted decrease of one more step.
    value: f64,
    /// Number of model evaluations that the point took.
    rounds: usize,
}

/// Jacobian at the estimate with Broyden updates: `J = J0 + sum d v'`.
struct BroydenJacobian<'a> {
    minimum: &'a Minimum,
    updates: Vec<(DVector<f64>, DVector<f64>)>,
    /// Information matrix: `J' W J` plus the information of the priors.
    information: DMatrix<f64>,
}

impl<'a> BroydenJacobian<'a> {
    fn new(minimum: &'a Minimum) -> Self {
        Self {
            minimum,
            updates: Vec::new(),
            information: minimum.information.clone(),
        }
    }

    /// Computes `J s`, the linear change of the residuals along a step `s`.
    fn times(&self, step: &DVector<f64>) -> DVector<f64> {
        let mut out = &self.minimum.evaluation.jacobian * step;
        for (d, v) in &self.updates {
            out.axpy(v.dot(step), d, 1.0);
        }
        out
    }

    /// Computes `J' r` with the updated Jacobian `J`.
    fn transposed(&self, r: &DVector<f64>) -> DVector<f64> {
        let mut out = self.minimum.evaluation.jacobian.tr_mul(r);
        for (d, v) in &self.updates {
            out.axpy(d.dot(r), v, 1.0);
        }
        out
    }

    /// Updates the Jacobian so that it reproduces the observed `change` of the residuals along a step. `metric` weighs the components of the
    /// step.
    fn learn(&mut self, step: &DVector<f64>, change: &DVector<f64>, metric: &DVector<f64>) {
        let v = step.component_mul(metric);
        let size = v.dot(step);
        if !(size > 0.0) {
            return;
        }
        let v = v / size;
        let d = change - self.times(step);
        let weighted = d.component_mul(&self.minimum.weights);
        let a = self.transposed(&weighted);
        self.information += &a * v.transpose() + &v * a.transpose();
        self.information.ger(d.dot(&weighted), &v, &v, 1.0);
        self.updates.push((d, v));
    }
}

impl Profile<'_> {
    /// Returns the unknowns after a step from the estimate.
    fn place(&self, step: &DVector<f64>) -> Vec<f64> {
        self.problem.retract(&self.minimum.x, step)
    }

    /// Returns a step that changes only unknown `k`, by `size`.
    fn alone(&self, size: f64) -> DVector<f64> {
        let mut step = DVector::zeros(self.along.len());
        step[self.k] = size;
        step
    }

    /// Returns the step of unknown `k` at which one side of the interval ends; `None` if that side is unbounded.
    fn side(&mut self, direction: f64, sd: f64) -> Option<f64> {
        let k = self.k;
        let (lower, upper) = self.problem.limits(self.scale, PROFILE_MAX_LN_DISTANCE);
        let farthest = if direction > 0.0 { upper[k] } else { -lower[k] };
        let target = HALF_CHI_SQUARE_95.sqrt();
        let mut learnt = BroydenJacobian::new(self.minimum);
        // Step of unknown `k` and square root of the rise, at the last point inside the interval and at the first point outside.
        let (mut inner, mut outer) = ((0.0, 0.0), None::<(f64, f64)>);
        let mut from = self.alone(0.0);
        let mut reach = (NORMAL_QUANTILE_975 * sd).min(farthest);
        for _ in 0..PROFILE_MAX_POINTS {
            let start = &from + &self.along * (direction * (reach - inner.0));
            let mut found = self.point(direction * reach, start, &mut learnt);
            let rise = |value: f64, base: f64| (value - base).max(0.0);
            let near_end = |point: &ProfilePoint, base: f64| {
                rise(point.value, base) > HALF_CHI_SQUARE_95 - PROFILE_INTERPOLATION_NATS
            };
            if found.as_ref().is_none_or(|point| {
                point.rounds > PROFILE_FEW_EVALUATIONS && near_end(point, self.base)
            }) {
                // A search that starts from the estimate may find a lower objective than the continuation of the path.
                let other = self.point(
                    direction * reach,
                    self.alone(0.0),
                    &mut BroydenJacobian::new(self.minimum),
                );
                let value = |point: &Option<ProfilePoint>| {
                    point.as_ref().map_or(f64::INFINITY, |p| p.value)
                };
                if value(&other) < value(&found) {
                    found = other;
                }
            }
            if let Some(point) = &found {
                self.base = self.base.min(point.value);
            }
            let height = found
                .as_ref()
                .map(|point| rise(point.value, self.base).sqrt());
            match (height, found) {
                (Some(height), Some(point)) if height < target => {
                    if reach >= farthest {
                        return None;
                    }
                    inner = (reach, height);
                    from = point.step;
                }
                (Some(height), _) => outer = Some((reach, height)),
                // A point where the model has no solution lies outside the interval.
                (None, _) => outer = Some((reach, 3.0 * target)),
            }
            let near = height.is_some_and(|height| {
                (height * height - HALF_CHI_SQUARE_95).abs() < PROFILE_INTERPOLATION_NATS
            });
            reach = match outer {
                // Close to the end, extrapolation along the straight line through the minimum and this point is accurate enough.
                None if near => {
                    let end = reach * target / inner.1;
                    return (end < farthest).then_some(direction * end);
                }
                None => (reach * (target / inner.1.max(0.1)).clamp(1.15, 3.0)).min(farthest),
                Some(outer) => {
                    let share = (target - inner.1) / (outer.1 - inner.1);
                    let next = inner.0 + share * (outer.0 - inner.0);
                    if near || outer.0 - inner.0 < 0.05 * outer.0 {
                        return Some(direction * next);
                    }
                    // If the objective rises steeply outside, interpolation gives a point too close to the inner point. The next point
                    // therefore lies at least a quarter of the bracket away from the inner point.
                    next.max(inner.0 + 0.25 * (outer.0 - inner.0))
                }
            };
        }
        Some(direction * reach)
    }

    /// Minimises the objective over the other unknowns for a step `size` of unknown `k`, starting from `start`. Returns `None` if the model has
    /// no solution.
    fn point(
        &mut self,
        size: f64,
        mut start: DVector<f64>,
        learnt: &mut BroydenJacobian<'_>,
    ) -> Option<ProfilePoint> {
        let k = self.k;
        let (lower, upper) = self.problem.limits(self.scale, PROFILE_MAX_OTHER_STEP);
        for j in 0..start.len() {
            start[j] = start[j].clamp(lower[j], upper[j]);
        }
        start[k] = size;
        let mut last = (self.alone(0.0), self.minimum.evaluation.residual.clone());
        let mut best: Option<(DVector<f64>, DVector<f64>, f64)> = None;
        let mut step = start;
        let mut shorter = 1.0;
        for round in 1..=PROFILE_MAX_EVALUATIONS {
            let x = self.place(&step);
            let evaluation = self.problem.evaluate(&x, false)?;
            let weights = self.problem.weights(&evaluation.residual);
            let value = objective(&evaluation, &weights, &x, &self.priors);
            let r = evaluation.residual;
            learnt.learn(&(&step - &last.0), &(&r - &last.1), &self.metric);
            last = (step.clone(), r.clone());
            if best.as_ref().is_none_or(|(_, _, least)| value < *least) {
                best = Some((step, r.component_mul(&weights), value));
                shorter = 1.0;
            } else {
                shorter *= 0.5;
            }
            let (at, weighted, least) = best.as_ref().expect("set in the first round");
            let room = |bounds: &[f64], none: f64| -> Vec<f64> {
                let each = bounds.iter().zip(at).zip(&self.held);
                each.map(|((bound, at), held)| if *held { none } else { bound - at })
                    .collect()
            };
            let bounds = (room(&lower, f64::NEG_INFINITY), room(&upper, f64::INFINITY));
            let (next, gain) = self.constrained(at, weighted, &bounds, learnt);
            if gain < PROFILE_DECREMENT_NATS {
                let value = least - gain;
                return Some(ProfilePoint {
                    step: at.clone(),
                    value,
                    rounds: round,
                });
            }
            step = at + next * shorter;
        }
        let (at, _, least) = best?;
        self.fitted(&at, least)
    }

    /// Returns the step of the other unknowns that minimises the objective of the updated linear model, and the predicted decrease.
    fn constrained(
        &self,
        at: &DVector<f64>,
        weighted: &DVector<f64>,
        (lower, upper): &(Vec<f64>, Vec<f64>),
        learnt: &BroydenJacobian<'_>,
    ) -> (DVector<f64>, f64) {
        let mut right = -learnt.transposed(weighted);
        let [x, up, down] = [0.0, PROFILE_DIFFERENCE_STEP, -PROFILE_DIFFERENCE_STEP]
            .map(|h| self.place(&at.add_scalar(h)));
        for (j, prior) in self.priors.iter().enumerate() {
            right[j] -= prior.pull(x[j]) * (up[j] - down[j]) / (2.0 * PROFILE_DIFFERENCE_STEP);
        }
        let mut information = learnt.information.clone();
        for (j, held) in self.held.iter().enumerate() {
            if *held {
                information.fill_row(j, 0.0);
                information.fill_column(j, 0.0);
                information[(j, j)] = 1.0;
                right[j] = 0.0;
            }
        }
        let (step, _) = bounded::solve(&information, &right, lower, upper);
        let gain = step.dot(&right) - 0.5 * step.dot(&(&information * &step));
        (step, gain)
    }

    /// Minimises the objective over the other unknowns by a fit with derivatives, starting from the step `from`. `least` is the lowest
    /// objective known at this point.
    fn fitted(&mut self, from: &DVector<f64>, least: f64) -> Option<ProfilePoint> {
        let tolerances = Tolerances {
            decrement: PROFILE_DECREMENT_NATS,
            step: PROFILE_STEP,
            max_iterations: PROFILE_MAX_TRIAL_STEPS,
        };
        let start = self.place(from);
        let found = minimise(
            self.problem,
            &start,
            &self.priors,
            self.scale,
            &self.held,
            tolerances,
        )?;
        Some(ProfilePoint {
            step: self.problem.step_to(&self.minimum.x, &found.x),
            value: (found.objective - found.decrement).min(least),
            rounds: PROFILE_MAX_EVALUATIONS + found.iterations,
        })
    }
}
