//! Posterior maximum of a linear model, and constrained steps from the linearisation point towards it.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::factor::Factor;

/// Posterior maximum of a linear model at given variance components.
pub struct Solution {
    /// Log evidence plus the log prior density of the variance components.
    pub ln_z: f64,
    /// Predicted decrease of the negative log posterior by `step`, in nats.
    pub gain: f64,
    /// Step from the linearisation point to the posterior maximum.
    pub step: DVector<f64>,
    /// Cholesky factor of the information matrix, scaled by the prior standard deviations.
    pub(super) factor: Factor,
    /// Prior standard deviations of the unknowns.
    pub(super) S: DVector<f64>,
}

impl Solution {
    /// Returns the difference in log posterior of the linear model between the maximum and the step `other`, in nats.
    pub fn nats_below_maximum(&self, other: &DVector<f64>) -> f64 {
        let off =
            (other - &self.step).zip_map(&self.S, |off, s| if s > 0.0 { off / s } else { 0.0 });
        0.5 * self.factor.quadratic(&off)
    }

    /// Returns the step to the maximum with the steps of some unknowns limited to intervals. First, the unknown that exceeds its limit by the
    /// largest factor is fixed at the limit, and the others are optimised again. This is repeated until no limit is exceeded. If all were fixed
    /// at once, unknowns that the readings determine only in sum would leave the valley of the objective.
    pub fn box_constrained_step(&self, limits: &[(usize, (f64, f64))]) -> DVector<f64> {
        let mut step = self.step.clone();
        let mut held: Vec<(usize, f64)> = Vec::new();
        while held.len() < limits.len() {
            let beyond = |(place, (low, high)): &(usize, (f64, f64))| {
                let (place, here) = (*place, step[*place]);
                let limit = if here < 0.0 { *low } else { *high };
                let is_free = held.iter().all(|(k, _)| *k != place);
                let excess = here / limit;
                (is_free && excess > 1.0).then_some((place, limit, excess))
            };
            let all = limits.iter().filter_map(beyond);
            let Some((place, limit, _)) = all.max_by(|a, b| a.2.total_cmp(&b.2)) else {
                break;
            };
            held.push((place, limit));
            step = self.step_with(&held);
        }
        for (place, (low, high)) in limits {
            step[*place] = step[*place].clamp(*low, *high);
        }
        step
    }

    /// Returns the step to the maximum with all unknowns that exceed their limits fixed at the limits at once.
    pub fn step_clamped(&self, limits: &[(usize, (f64, f64))]) -> DVector<f64> {
        let limited: Vec<(usize, f64)> = limits
            .iter()
            .map(|(k, (low, high))| (*k, self.step[*k].clamp(*low, *high)))
            .filter(|(k, step)| *step != self.step[*k])
            .collect();
        let mut step = self.step_with(&limited);
        for (place, (low, high)) in limits {
            step[*place] = step[*place].clamp(*low, *high);
        }
        step
    }

    /// Returns the posterior maximum with an additional penalty `x' bend x / 2` in the negative log posterior. Here `x` are the steps of the
    /// unknowns at `places`. Returns `None` if there is no finite solution.
    pub fn with_quadratic_penalty(&self, places: &[usize], bend: &DMatrix<f64>) -> Option<Self> {
        let across = self.across(places);
        // Woodbury identity: (H + E B E')^-1 b = x - U B (1 + E'U B)^-1 E'x with U = H^-1 E and x = H^-1 b.
        let inner = across.select_rows(places) * bend;
        let inner = DMatrix::identity(places.len(), places.len()) + inner;
        let kept = inner.lu().solve(&self.step.select_rows(places))?;
        let step = &self.step - across * (bend * kept);
        step.iter().all(|x| x.is_finite()).then(|| Self {
            gain: self.gain - self.nats_below_maximum(&step),
            step,
            ln_z: self.ln_z,
            factor: self.factor.clone(),
            S: self.S.clone(),
        })
    }

    /// Returns the columns of the posterior covariance that belong to the unknowns at `places`.
    fn across(&self, places: &[usize]) -> DMatrix<f64> {
        let n = self.step.len();
        let mut across = DMatrix::zeros(n, places.len());
        for (k, place) in places.iter().enumerate() {
            let mut unit = DVector::zeros(n);
            unit[*place] = self.S[*place];
            let column = self.factor.solve(&unit).component_mul(&self.S);
            across.set_column(k, &column);
        }
        across
    }

    /// Returns the step to the maximum with the steps of some unknowns prescribed, as pairs of index and step.
    fn step_with(&self, given: &[(usize, f64)]) -> DVector<f64> {
        if given.is_empty() {
            return self.step.clone();
        }
        let places: Vec<usize> = given.iter().map(|(place, _)| *place).collect();
        let across = self.across(&places);
        let off = DVector::from_iterator(
            given.len(),
            given.iter().map(|(place, value)| value - self.step[*place]),
        );
        match Cholesky::new(across.select_rows(&places)) {
            Some(factor) => &self.step + across * factor.solve(&off),
            None => self.step.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares the result with a direct solution of the normal equations that include the penalty, for three unknowns with priors of different
    /// widths.
    #[test]
    fn a_held_step_is_that_of_the_whole_objective() {
        let jacobian =
            DMatrix::from_row_slice(3, 3, &[2.0, 0.3, -1.0, 0.5, 1.5, 0.7, -0.2, 1.1, 3.0]);
        let S = DVector::from_vec(vec![0.5, 2.0, 1.0]);
        let scaled = &jacobian * DMatrix::from_diagonal(&S);
        let information = scaled.tr_mul(&scaled) + DMatrix::identity(3, 3);
        let residual = DVector::from_vec(vec![1.0, -2.0, 0.4]);
        let b = scaled.tr_mul(&residual);
        let factor = Factor::new(information.clone()).unwrap();
        let mu = factor.solve(&b);
        let reached = Solution {
            ln_z: 0.0,
            gain: 0.5 * b.dot(&mu),
            step: mu.component_mul(&S),
            factor,
            S: S.clone(),
        };
        // The matrix has rank one and is therefore singular.
        let bend = DMatrix::from_row_slice(2, 2, &[4.0, -6.0, -6.0, 9.0]);
        let held = reached.with_quadratic_penalty(&[0, 2], &bend).unwrap();
        let mut whole = information;
        for (i, row) in [0, 2].into_iter().enumerate() {
            for (j, column) in [0, 2].into_iter().enumerate() {
                whole[(row, column)] += S[row] * bend[(i, j)] * S[column];
            }
        }
        let expected = whole.lu().solve(&b).unwrap().component_mul(&S);
        assert!((&held.step - expected).norm() < 1e-12);
        let above = reached.gain - held.gain;
        assert!(above > 0.0 && (above - reached.nats_below_maximum(&held.step)).abs() < 1e-12);
    }

    /// The sum of the second unknown and half the first is known far better than either unknown. With the first unknown at its limit, the
    /// second must keep this sum and stay within its own limit.
    #[test]
    fn a_step_within_limits_stays_in_its_valley() {
        let valley = DMatrix::from_row_slice(2, 2, &[0.25, 0.5, 0.5, 1.0]) * 1e6;
        let information = valley + DMatrix::identity(2, 2) * 1e-2;
        let step = DVector::from_vec(vec![10.0, -5.0]);
        let reached = Solution {
            ln_z: 0.0,
            gain: 0.0,
            factor: Factor::new(information).unwrap(),
            S: DVector::from_element(2, 1.0),
            step,
        };
        let limits = [(0, (-1.2, 1.2)), (1, (-1.2, 1.2))];
        let within = reached.box_constrained_step(&limits);
        assert!((within[0] - 1.2).abs() < 1e-6, "{within}");
        assert!((within[1] + 0.6).abs() < 1e-6, "{within}");
    }
}
