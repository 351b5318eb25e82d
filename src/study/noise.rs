//! Seeded measuring noise.

use rand::{RngExt, SeedableRng};
use rand_distr::{StandardNormal, StudentT};
use rand_pcg::Pcg64;

use admire_solver::mechanics::Vec3;

/// A stream of normal numbers: the same seed and purpose give the same numbers on every machine.
#[derive(Clone, Debug)]
pub struct Noise(Pcg64);

impl Noise {
    /// The stream of one purpose: what is drawn for one purpose never moves the numbers of another.
    pub fn new(seed: u64, purpose: &str) -> Self {
        // FNV-1a of the purpose keeps the streams apart.
        let stream = purpose
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            });
        Self(Pcg64::seed_from_u64(seed ^ stream))
    }

    /// A standard normal number.
    pub fn normal(&mut self) -> f64 {
        self.0.sample(StandardNormal)
    }

    /// A number between `-most` and `most`, all alike likely.
    pub fn within(&mut self, most: f64) -> f64 {
        most * self.0.random_range(-1.0..=1.0)
    }

    /// A whole number from zero to below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }

    /// Three independent numbers: a Student t of the given degrees of freedom, scaled; normal if these are infinite.
    pub fn heavy(&mut self, tails: f64, scale: f64) -> Vec3 {
        match StudentT::new(tails) {
            Ok(law) if tails.is_finite() => Vec3::from_fn(|_, _| self.0.sample(law)) * scale,
            _ => self.vector(scale),
        }
    }

    /// Three independent normal numbers of the given sd.
    pub fn vector(&mut self, sigma: f64) -> Vec3 {
        Vec3::new(self.normal(), self.normal(), self.normal()) * sigma
    }
}
