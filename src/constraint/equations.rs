use crate::mechanics::{Mat6, RelativeMotion, Vec6};

/// Residuals of up to six scalar equations between two markers, with derivatives in J axes.
#[derive(Clone, Debug)]
pub struct Equations {
    /// How many equations.
    pub count: usize,
    /// Residuals; the first `count` are used.
    pub residual: [f64; 6],
    /// Row k: derivative of residual k by (change of `p_ij_j`, rotation `dtheta` in J axes).
    pub jacobian: [Vec6; 6],
    /// Sum over k of `multipliers[k]` times the derivative of `jacobian[k]` (as a column) by the motion: 6 by 6, not symmetric in
    /// general because rotations do not commute.
    pub curvature: Mat6,
}

impl Default for Equations {
    fn default() -> Self {
        Self {
            count: 0,
            residual: [0.0; 6],
            jacobian: [Vec6::zeros(); 6],
            curvature: Mat6::zeros(),
        }
    }
}

/// A holonomic constraint between two markers. The wrench on I at the I origin in J axes is `-sum_k multipliers[k] * jacobian[k]`.
pub trait Constraint: std::fmt::Debug + Send + Sync {
    /// How many scalar equations.
    fn count(&self) -> usize;

    /// The name of each equation as ADAMS prints it when redundant, for example `Zi.Xj`.
    fn equation_name(&self, k: usize) -> &'static str;

    /// Residuals, Jacobian and curvature at this motion.
    fn evaluate(&self, motion: &RelativeMotion, multipliers: &[f64], out: &mut Equations);
}
