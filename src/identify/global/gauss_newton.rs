//! Gauss-Newton with a trust region (Levenberg-Marquardt) on whitened residuals with Gaussian priors.
//!
//! Knows neither decks nor marks: only a function that gives residuals and their derivatives.

use nalgebra::{DMatrix, DVector};

use super::observation::Evaluation;

/// A sum of squares to minimise: `1/2 |r(x)|^2 + 1/2 sum ((x - mean)/sd)^2`.
pub trait LeastSquares {
    /// Residuals, with the Jacobian when asked for. `None` where the model has no answer.
    fn evaluate(&mut self, x: &[f64], with_jacobian: bool) -> Option<Evaluation>;

    /// Weight of each residual at these residuals; 1 for a Gaussian likelihood.
    fn weights(&self, residual: &DVector<f64>) -> DVector<f64> {
        DVector::from_element(residual.len(), 1.0)
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
    fn information(self) -> f64 {
        if self.sd.is_finite() {
            1.0 / (self.sd * self.sd)
        } else {
            0.0
        }
    }

    fn pull(self, x: f64) -> f64 {
        if self.sd.is_finite() {
            (x - self.mean) / (self.sd * self.sd)
        } else {
            0.0
        }
    }

    fn cost(self, x: f64) -> f64 {
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
            decrement: 1e-7,
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
    /// Accepted steps.
    pub iterations: usize,
    /// Why it ended.
    pub ending: Ending,
}

/// Objective of weighted residuals and priors.
fn objective(evaluation: &Evaluation, weights: &DVector<f64>, x: &[f64], priors: &[Prior]) -> f64 {
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
    let mut information = weighted.tr_mul(&weighted);
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
/// The damping follows Nielsen (1999): it shrinks as far as the quadratic model predicted the gain well and grows geometrically
/// after failures. `None` only if the model has no answer at the start.
pub fn minimise(
    problem: &mut dyn LeastSquares,
    start: &[f64],
    priors: &[Prior],
    scale: &[f64],
    held: &[bool],
    tolerances: Tolerances,
) -> Option<Minimum> {
    let mut x = start.to_vec();
    let mut evaluation = problem.evaluate(&x, true)?;
    let mut weights = problem.weights(&evaluation.residual);
    let mut value = objective(&evaluation, &weights, &x, priors);
    let (mut damping, mut growth) = (1e-4, 2.0);
    let (mut iterations, mut ending) = (0, Ending::MaxIterations);
    for _ in 0..tolerances.max_iterations {
        let (information, gradient) = normal_equations(&evaluation, &weights, &x, priors);
        let Some((step, decrement)) = trial_step(&information, &gradient, scale, held, damping)
        else {
            damping *= growth;
            growth *= 2.0;
            continue;
        };
        let longest = step
            .iter()
            .zip(scale)
            .map(|(s, scale)| (s / scale).abs())
            .fold(0.0, f64::max);
        if decrement <= tolerances.decrement || longest <= tolerances.step {
            ending = Ending::Converged;
            break;
        }
        // Two natural units at most, unknown by unknown, keep exponentials of ln K sane; what little the data say of one unknown must
        // not hold back the others.
        let step = step.zip_map(&DVector::from_column_slice(scale), |s, scale| {
            s.clamp(-2.0 * scale, 2.0 * scale)
        });
        let trial: Vec<f64> = x.iter().zip(step.iter()).map(|(x, s)| x + s).collect();
        let predicted = -gradient.dot(&step) - 0.5 * step.dot(&(&information * &step));
        let outcome = problem.evaluate(&trial, true).map(|next| {
            let gained = value - objective(&next, &weights, &trial, priors);
            (next, gained)
        });
        match outcome {
            Some((next, gained)) if gained > 0.0 && gained.is_finite() => {
                let ratio = gained / predicted.max(f64::MIN_POSITIVE);
                // Faster down than Nielsen's third: directions the data hardly know need damping far below their diagonal.
                damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(0.01, 2.0);
                damping = damping.max(1e-16);
                growth = 2.0;
                x = trial;
                evaluation = next;
                weights = problem.weights(&evaluation.residual);
                value = objective(&evaluation, &weights, &x, priors);
                iterations += 1;
                if !problem.progress(iterations, &x, value) {
                    ending = Ending::Stopped;
                    break;
                }
            }
            _ => {
                damping *= growth;
                growth *= 2.0;
                if damping > 1e12 {
                    // Round-off hides any further gain: at a minimum this is convergence.
                    ending = if decrement <= 1e-3 {
                        Ending::Converged
                    } else {
                        Ending::Stalled
                    };
                    break;
                }
            }
        }
    }
    let (information, _) = normal_equations(&evaluation, &weights, &x, priors);
    Some(Minimum {
        x,
        objective: value,
        evaluation,
        weights,
        information,
        iterations,
        ending,
    })
}

/// The damped step, and the decrement `-g.p / 2` of the undamped model along it.
fn trial_step(
    information: &DMatrix<f64>,
    gradient: &DVector<f64>,
    scale: &[f64],
    held: &[bool],
    damping: f64,
) -> Option<(DVector<f64>, f64)> {
    let mut damped = information.clone();
    let mut right = -gradient;
    for k in 0..scale.len() {
        if held[k] {
            damped.fill_row(k, 0.0);
            damped.fill_column(k, 0.0);
            damped[(k, k)] = 1.0;
            right[k] = 0.0;
        } else {
            // Marquardt's scaling by the information itself, with the natural scale where the data say nothing.
            let floor = 1e-9 / (scale[k] * scale[k]);
            damped[(k, k)] += damping * information[(k, k)].max(floor);
        }
    }
    let step = nalgebra::Cholesky::new(damped)?.solve(&right);
    let decrement = -0.5
        * step
            .iter()
            .zip(gradient.iter())
            .zip(held)
            .map(|((s, g), held)| if *held { 0.0 } else { s * g })
            .sum::<f64>();
    step.iter()
        .all(|s| s.is_finite())
        .then_some((step, decrement))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley as residuals: minimum 0 at (1, 1).
    struct Valley;

    impl LeastSquares for Valley {
        fn evaluate(&mut self, x: &[f64], _with_jacobian: bool) -> Option<Evaluation> {
            Some(Evaluation {
                residual: DVector::from_vec(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]),
                jacobian: DMatrix::from_row_slice(2, 2, &[-20.0 * x[0], 10.0, -1.0, 0.0]),
            })
        }
    }

    const NO_PRIOR: Prior = Prior {
        mean: 0.0,
        sd: f64::INFINITY,
    };

    #[test]
    fn a_curved_valley_is_followed_to_its_end() {
        let found = minimise(
            &mut Valley,
            &[-1.2, 1.0],
            &[NO_PRIOR; 2],
            &[1.0; 2],
            &[false; 2],
            Tolerances::default(),
        )
        .unwrap();
        assert_eq!(found.ending, Ending::Converged);
        assert!(
            (found.x[0] - 1.0).abs() < 1e-4 && (found.x[1] - 1.0).abs() < 1e-4,
            "{:?}",
            found.x
        );
    }

    #[test]
    fn a_held_unknown_stays_and_a_prior_pulls() {
        let held = minimise(
            &mut Valley,
            &[0.5, 1.0],
            &[NO_PRIOR; 2],
            &[1.0; 2],
            &[true, false],
            Tolerances::default(),
        )
        .unwrap();
        assert_eq!(held.x[0], 0.5);
        assert!((held.x[1] - 0.25).abs() < 1e-6);
        // With x0 held at 0.5 the data say x1 = 0.25 with information 100; a prior of mean 1 and information 100 meets half-way.
        let priors = [NO_PRIOR, Prior { mean: 1.0, sd: 0.1 }];
        let pulled = minimise(
            &mut Valley,
            &[0.5, 1.0],
            &priors,
            &[1.0; 2],
            &[true, false],
            Tolerances::default(),
        )
        .unwrap();
        assert!((pulled.x[1] - 0.625).abs() < 1e-6);
    }
}
