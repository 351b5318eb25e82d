//! The shortest of the changes that solve the linear equations of a model with free motions.

use super::measures::largest;
use super::rank::UNDETERMINED;
use crate::linear::Lu;
use crate::system::System;

/// The motions that nothing resists. Solutions of the linear equations are unique but for a share of each; without that share they are the
/// shortest, with rotations times the model's length. They then depend neither on which unknowns the factors left free nor on their axes.
#[derive(Clone, Debug, Default)]
pub(super) struct Unresisted {
    /// Orthonormal in the product of [`weights`](Self::weights).
    motions: Vec<Vec<f64>>,
    /// Of each unknown: one for a shift, the square of the model's length for a rotation, none for what is no motion.
    weights: Vec<f64>,
}

impl Unresisted {
    /// Those that factors found.
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
            new.take_off(&mut z);
            let norm = new.product(&z, &z).sqrt();
            // Where no part moves, reactions are what nothing determines.
            if norm > UNDETERMINED * largest(&z[system.first_equation..]) {
                for value in &mut z {
                    *value /= norm;
                }
                new.motions.push(z);
            }
        }
        new
    }

    /// Makes a solution the shortest.
    pub(super) fn take_off(&self, dx: &mut [f64]) {
        for motion in &self.motions {
            let share = self.product(dx, motion);
            for (value, along) in dx.iter_mut().zip(motion) {
                *value -= share * along;
            }
        }
    }

    /// Makes weights of the unknowns those that see of every solution what they saw of its shortest.
    pub(super) fn ignore(&self, weights: &mut [f64]) {
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
