//! Draws from the posterior by Hamiltonian Monte Carlo.
//!
//! Let `x = estimate + L z`, where `L L'` is the covariance of the fit. If the model is nearly linear, z is nearly a unit Gaussian, and a
//! trajectory over a quarter of an oscillation ends at a nearly independent draw. Leapfrog steps use the exact gradient
//! `L'(J'r + (x - m)/sd^2)`.

use nalgebra::DVector;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::estimate::Estimate;
use crate::{Row, Status, Stream, normal};
use admire_identify::global::MarginalProblem;
use admire_identify::global::gauss_newton::LeastSquares;

/// Trial numbers of leapfrog steps per quarter oscillation, in ascending order. The pilot run chooses one of them.
const STEPS: [usize; 5] = [4, 6, 9, 14, 22];
/// Smallest mean acceptance probability in the pilot run at which a number of leapfrog steps is accepted.
const ACCEPT: f64 = 0.85;
/// Number of pilot chains. They start at different points, because the posterior may be much narrower far from the estimate.
const PILOTS: u64 = 8;
/// Number of trajectories in each pilot chain.
const PILOT: u64 = 4;
/// Probability content of the region of a Gaussian posterior within which chains start.
const TYPICAL: f64 = 0.99;
/// Number of draws discarded at the beginning of every chain.
const WARM_UP: u64 = 30;
/// Half range of the random trajectory length, relative to the mean length. The randomness avoids periodic trajectories.
const JITTER: f64 = 0.2;

/// Sampler that draws from the posterior in several chains.
pub(crate) struct Posterior<'a> {
    estimate: &'a Estimate<'a>,
    seed: u64,
    /// Number of draws in a chain.
    length: u64,
    /// Number of leapfrog steps in a trajectory.
    pub steps: usize,
}

/// Point in whitened coordinates, with its energy.
struct PosteriorPoint {
    z: DVector<f64>,
    /// Energy: half the chi-square, including the priors.
    energy: f64,
    /// Gradient of the energy with respect to `z`.
    gradient: DVector<f64>,
}

/// State of a chain at the end of a trajectory.
struct End {
    x: Vec<f64>,
    /// Half the chi-square, including the priors, at this state.
    energy: f64,
    /// Probability with which the end of the trajectory is accepted.
    probability: f64,
}

impl<'a> Posterior<'a> {
    /// Prepares the sampler of a fit, with chains of this length. A short pilot run chooses the smallest number of leapfrog steps with
    /// sufficient acceptance.
    pub(crate) fn new(estimate: &'a Estimate<'a>, seed: u64, length: u64) -> Self {
        let mut new = Self {
            estimate,
            seed,
            length,
            steps: STEPS[0],
        };
        let pilots: Vec<Stream> = (0..PILOTS)
            .map(|pilot| Stream::named(seed, &format!("pilot {pilot}")))
            .collect();
        let starts: Vec<Vec<f64>> = pilots.iter().map(|pilot| new.scattered(pilot)).collect();
        for steps in STEPS {
            new.steps = steps;
            let mut accept = 0.0;
            for (pilot, start) in pilots.iter().zip(&starts) {
                let mut x = start.clone();
                for draw in 0..PILOT {
                    let end = new.draw(&x, pilot, 1 + draw);
                    accept += end.probability / (PILOT * PILOTS) as f64;
                    x = end.x;
                }
            }
            if accept >= ACCEPT {
                break;
            }
        }
        new
    }

    /// Returns the chain number and the draw number of a case, both counted from 0.
    pub(crate) fn place(&self, case: u64) -> (u64, u64) {
        (case / self.length, case % self.length)
    }

    /// Makes one draw. The outputs are the identified parameters, half the chi-square including the priors, and the acceptance probability
    /// of the trajectory's end.
    pub(crate) fn run(&self, case: u64, before: Option<&Row>) -> Row {
        let start = std::time::Instant::now();
        let (chain, draw) = self.place(case);
        let stream = Stream::named(self.seed, &format!("chain {chain}"));
        let count = self.estimate.marginal.len();
        // The next draw starts from the values in the table. An interrupted chain therefore continues exactly as an uninterrupted chain would.
        let x: Vec<f64> = if let Some(row) = before {
            self.estimate.coordinates(&row.outputs[..count])
        } else {
            let mut x = self.scattered(&stream);
            for draw in 0..WARM_UP {
                x = self.draw(&x, &stream, 1 + draw).x;
            }
            x
        };
        let end = self.draw(&x, &stream, 1 + WARM_UP + draw);
        let mut outputs = self.estimate.values(&end.x);
        outputs.extend([end.energy, end.probability]);
        Row {
            case,
            status: Status::Ok,
            reason: String::new(),
            seconds: start.elapsed().as_secs_f64(),
            outputs,
        }
    }

    /// Returns the start of a chain, drawn from the covariance of the fit. The start is moved towards the estimate if the model has no equilibrium
    /// there, or if the readings exclude it. Trajectories with the step length of the posterior could not leave such a point.
    fn scattered(&self, stream: &Stream) -> Vec<f64> {
        let count = self.estimate.marginal.len() as u64;
        let z = normals(stream, 0, count);
        let least = self.energy(
            &self.estimate.minimum.x,
            &self.estimate.minimum.evaluation.residual,
        );
        let far = ChiSquared::new(count as f64)
            .map_or(f64::INFINITY, |squares| 0.5 * squares.inverse_cdf(TYPICAL));
        (0..8)
            .map(|halvings| self.x(&(&z * 0.5_f64.powi(halvings))))
            .find(|x| {
                let fit = self.estimate.again();
                let point = fit.ok().and_then(|mut fit| self.point(&mut fit, self.z(x)));
                point.is_some_and(|point| point.energy - least < far)
            })
            .unwrap_or_else(|| self.estimate.minimum.x.clone())
    }

    /// Computes one trajectory that starts at x.
    fn draw(&self, x: &[f64], stream: &Stream, number: u64) -> End {
        let count = self.estimate.marginal.len() as u64;
        let first = number * (count + 2);
        let mut stay = End {
            x: x.to_vec(),
            energy: f64::NAN,
            probability: 0.0,
        };
        // This fit depends only on x and the stream.
        let Ok(mut fit) = self.estimate.again() else {
            return stay;
        };
        let Some(mut at) = self.point(&mut fit, self.z(x)) else {
            return stay;
        };
        stay.energy = at.energy;
        let mut momentum = normals(stream, first, count);
        let before = at.energy + 0.5 * momentum.norm_squared();
        let length = 1.0 + JITTER * (2.0 * stream.uniform(first + count) - 1.0);
        let step = length * std::f64::consts::FRAC_PI_2 / self.steps as f64;
        for _ in 0..self.steps {
            momentum.axpy(-0.5 * step, &at.gradient, 1.0);
            let z = &at.z + &momentum * step;
            let Some(next) = self.point(&mut fit, z) else {
                return stay;
            };
            at = next;
            momentum.axpy(-0.5 * step, &at.gradient, 1.0);
        }
        let after = at.energy + 0.5 * momentum.norm_squared();
        let probability = libm::exp((before - after).min(0.0));
        if stream.uniform(first + count + 1) < probability {
            End {
                x: self.x(&at.z),
                energy: at.energy,
                probability,
            }
        } else {
            End {
                probability,
                ..stay
            }
        }
    }

    fn x(&self, z: &DVector<f64>) -> Vec<f64> {
        let step = &self.estimate.root * z;
        let x = self.estimate.minimum.x.iter().zip(step.iter());
        x.map(|(x, step)| x + step).collect()
    }

    fn z(&self, x: &[f64]) -> DVector<f64> {
        let own = &self.estimate.minimum.x;
        let step = DVector::from_iterator(x.len(), x.iter().zip(own).map(|(x, own)| x - own));
        let solved = self.estimate.root.solve_lower_triangular(&step);
        solved.unwrap_or_else(|| DVector::zeros(x.len()))
    }

    fn energy(&self, x: &[f64], residual: &DVector<f64>) -> f64 {
        let priors = self.estimate.marginal.priors().iter().zip(x);
        let own: f64 = priors.map(|(prior, x)| prior.cost(*x)).sum();
        0.5 * residual.norm_squared() + own
    }

    fn point(&self, fit: &mut MarginalProblem<'_>, z: DVector<f64>) -> Option<PosteriorPoint> {
        let x = self.x(&z);
        let found = fit.evaluate(&x, true)?;
        let mut slope = found.jacobian.tr_mul(&found.residual);
        for ((slope, prior), x) in slope
            .iter_mut()
            .zip(self.estimate.marginal.priors())
            .zip(&x)
        {
            *slope += prior.pull(*x);
        }
        let energy = self.energy(&x, &found.residual);
        let finite = energy.is_finite() && slope.iter().all(|s| s.is_finite());
        finite.then(|| PosteriorPoint {
            gradient: self.estimate.root.tr_mul(&slope),
            energy,
            z,
        })
    }
}

fn normals(stream: &Stream, first: u64, count: u64) -> DVector<f64> {
    let drawn = (first..first + count).map(|k| normal::quantile(stream.uniform(k)));
    DVector::from_iterator(count as usize, drawn)
}
