//! Minimum-norm solutions of the linear equations of a model with free motions.

use super::measures::largest;
use super::rank::UNDETERMINED;
use crate::linear::Lu;
use crate::system::System;

/// Null space of the Jacobian: the free motions of a model.
///
/// Two solutions of the linear equations differ by a combination of free motions. A solution without components along the free motions has minimum
/// norm, where rotations are multiplied by the model's length. This solution depends neither on the choice of unknowns without a pivot nor on the
/// part frames.
#[derive(Clone, Debug, Default)]
pub(super) struct FreeMotionSpace {
    /// Basis of the free motions, one list of unknowns per motion. The motions are orthonormal in the scalar product with the
    /// [`weights`](Self::weights).
    motions: Vec<Vec<f64>>,
    /// Weight of each unknown: 1 for a translation, the square of the model's length for a rotation, 0 for a reaction or a variable.
    weights: Vec<f64>,
}

impl FreeMotionSpace {
    /// Returns the null space found by a factorisation.
    pub(super) fn of(system: &System, factors: &Lu) -> Self {
        let mut new = Self::default();
        if factors.deficiency() == 0 {
            return new;
        }
        new.weights = vec![0.0; system.unknowns()];
        for body in &system.bodies {
            let own = &mut new.weights[body.first..body.first + body.freedoms];
            for (k, weight) in own.iter_mut().enumerate() {
                *weight = if k < 3 { 1.0 } else { system.length.powi(2) };
            }
        }
        for m in 0..factors.deficiency() {
            let mut z = factors.null_vector(m);
            new.project(&mut z);
            let norm = new.product(&z, &z).sqrt();
            // Null vectors in which no part moves are skipped, because they describe undetermined reactions.
            if norm > UNDETERMINED * largest(&z[system.first_equation..]) {
                for value in &mut z {
                    *value /= norm;
                }
                new.motions.push(z);
            }
        }
        new
    }

    /// Replaces a solution of the linear equations by the solution of minimum norm.
    pub(super) fn project(&self, dx: &mut [f64]) {
        for motion in &self.motions {
            let share = self.product(dx, motion);
            for (value, along) in dx.iter_mut().zip(motion) {
                *value -= share * along;
            }
        }
    }

    /// Applies the transpose of [`project`](Self::project) to `weights`. The product of the new weights with any solution equals the product of the
    /// old weights with the solution of minimum norm.
    pub(super) fn project_transposed(&self, weights: &mut [f64]) {
        for motion in self.motions.iter().rev() {
            let seen: f64 = weights.iter().zip(motion).map(|(w, z)| w * z).sum();
            for ((value, z), own) in weights.iter_mut().zip(motion).zip(&self.weights) {
                *value -= own * z * seen;
            }
        }
    }

    fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        let each = self.weights.iter().zip(a.iter().zip(b));
        each.map(|(weight, (a, b))| weight * a * b).sum()
    }
}
