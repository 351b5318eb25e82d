//! Student t distribution for heavy-tailed residuals.

use crate::settings::{STUDENT_T_DOF, STUDENT_T_SCALE_ITERATIONS};
use statrs::function::gamma::ln_gamma;

/// Student t distribution of residuals with mean zero.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Tails {
    /// Degrees of freedom of the t distribution.
    pub nu: f64,
    /// Scale of the t distribution, in the unit of the residuals.
    pub scale: f64,
}

impl Tails {
    /// Returns the t distribution of maximum likelihood, and its gain in log-likelihood over the Gaussian distribution in nats. Returns `None`
    /// for fewer than 30 residuals or zero variance.
    pub fn best(residuals: &[f64]) -> Option<(Self, f64)> {
        let n = residuals.len() as f64;
        let variance = residuals.iter().map(|r| r * r).sum::<f64>() / n;
        if n < 30.0 || variance <= 0.0 {
            return None;
        }
        let gauss = -0.5 * n * (libm::log(2.0 * std::f64::consts::PI * variance) + 1.0);
        let best = STUDENT_T_DOF
            .iter()
            .map(|&nu| {
                let mut square = 0.5 * variance;
                for _ in 0..STUDENT_T_SCALE_ITERATIONS {
                    let sum: f64 = residuals
                        .iter()
                        .map(|r| (nu + 1.0) / (nu + r * r / square) * r * r)
                        .sum();
                    square = sum / n;
                }
                let constant = ln_gamma(0.5 * (nu + 1.0))
                    - ln_gamma(0.5 * nu)
                    - 0.5 * libm::log(nu * std::f64::consts::PI * square);
                let logs: f64 = residuals
                    .iter()
                    .map(|r| libm::log1p(r * r / (nu * square)))
                    .sum();
                let value = n * constant - 0.5 * (nu + 1.0) * logs;
                (value, nu, square.sqrt())
            })
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        let (value, nu, scale) = best;
        Some((Self { nu, scale }, value - gauss))
    }

    /// Returns the precision of a coordinate with residual `r`: `kappa w / s^2` with the weight `w = (nu + 1)/(nu + (r/s)^2)`. The factor
    /// `kappa = (nu + 1)/(nu + 3)` accounts for the Fisher information of the t distribution. Without it, intervals would be too short by a
    /// factor of `sqrt((nu + 3)/(nu + 1))`. Source: Lange, Little and Taylor, JASA 84 (1989) 881.
    pub fn precision(self, residual: f64) -> f64 {
        let (nu, s) = (self.nu, self.scale);
        let weight = (nu + 1.0) / (nu + (residual / s).powi(2));
        (nu + 1.0) / (nu + 3.0) * weight / (s * s)
    }
}
