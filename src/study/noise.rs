//! Seeded random numbers for the simulation of measurement noise.

use rand::{RngExt, SeedableRng};
use rand_distr::{StandardNormal, StudentT};
use rand_pcg::Pcg64;

use admire_solver::mechanics::Vec3;

/// A stream of pseudo-random numbers. The same seed and purpose give the same numbers on every machine.
#[derive(Clone, Debug)]
pub struct Noise(Pcg64);

impl Noise {
    /// Creates the stream for one purpose. Streams with the same seed and different purposes are independent, so draws from one do not affect
    /// another.
    pub fn new(seed: u64, purpose: &str) -> Self {
        // The FNV-1a hash of the purpose separates the streams.
        let stream = purpose
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            });
        Self(Pcg64::seed_from_u64(seed ^ stream))
    }

    /// Draws a standard normal variable.
    pub fn normal(&mut self) -> f64 {
        self.0.sample(StandardNormal)
    }

    /// Draws a number that is uniformly distributed between `-most` and `most`.
    pub fn within(&mut self, most: f64) -> f64 {
        most * self.0.random_range(-1.0..=1.0)
    }

    /// Draws a whole number that is uniformly distributed from 0 to `count - 1`.
    pub fn below(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }

    /// Draws a vector of three independent Student t variables with `tails` degrees of freedom, multiplied by `scale`. For infinite `tails`,
    /// they are normal variables.
    pub fn student_t_vector(&mut self, tails: f64, scale: f64) -> Vec3 {
        match StudentT::new(tails) {
            Ok(law) if tails.is_finite() => Vec3::from_fn(|_, _| self.0.sample(law)) * scale,
            _ => self.vector(scale),
        }
    }

    /// Draws a vector of three independent normal variables with mean zero and standard deviation `sigma`.
    pub fn vector(&mut self, sigma: f64) -> Vec3 {
        Vec3::new(self.normal(), self.normal(), self.normal()) * sigma
    }
}
