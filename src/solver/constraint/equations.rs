//! Interface of a constraint between two markers. The module is independent of any particular constraint and of the part coordinates.

use crate::mechanics::{Mat3, RelativeMotion, Vec6};

/// Residuals of up to six scalar equations between two markers, with derivatives in J axes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Equations {
    /// Number of equations.
    pub count: usize,
    /// Residuals; the first `count` are used.
    pub residual: [f64; 6],
    /// Row k is the derivative of residual k with respect to the relative motion: (change of `p_ij_j`, rotation `dtheta` in J axes).
    pub jacobian: [Vec6; 6],
    /// Sum over k of `multipliers[k]` times the derivative of the rotational half of `jacobian[k]` (as a column) with respect to `dtheta`.
    ///
    /// All other blocks of the second derivative vanish: every equation is a component of `p_ij_j`, which enters linearly, plus a function
    /// of `R_ji` alone. The matrix is in general not symmetric, because rotations do not commute.
    pub curvature: Mat3,
    /// Derivative of `residual[0]` with respect to the constraint's parameter. Only constraints with a single equation have a parameter.
    pub residual_by_parameter: f64,
    /// Derivative of `jacobian[0]` with respect to the constraint's parameter.
    pub jacobian_by_parameter: Vec6,
}

impl Default for Equations {
    fn default() -> Self {
        Self {
            count: 0,
            residual: [0.0; 6],
            jacobian: [Vec6::zeros(); 6],
            curvature: Mat3::zeros(),
            residual_by_parameter: 0.0,
            jacobian_by_parameter: Vec6::zeros(),
        }
    }
}

/// Holonomic constraint between two markers. Its reaction wrench on I, at the I origin in J axes, is `-sum_k multipliers[k] * jacobian[k]`.
pub(crate) trait Constraint: std::fmt::Debug + Send + Sync {
    /// Returns the number of scalar equations.
    fn count(&self) -> usize;

    /// Returns the number of entries of `theta` that this constraint reads: zero or one. The entry is PITCH, PD, or the value of a MOTION.
    fn parameter_count(&self) -> usize {
        0
    }

    /// Returns the name of equation `k` as ADAMS prints it for redundant constraints, for example `Zi.Xj`. `D` is the vector from the J
    /// origin to the I origin.
    fn equation_name(&self, k: usize) -> &'static str;

    /// Returns whether the constraint reads `RelativeMotion::angles`. If not, the caller may leave these angles uncomputed.
    fn uses_angles(&self) -> bool {
        false
    }

    /// Computes residuals, Jacobian and curvature at a relative motion. `out` is reused: implementations overwrite the first `count`
    /// residuals and Jacobian rows, and `curvature`. A constraint with a parameter also overwrites the derivatives with respect to that
    /// parameter.
    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        multipliers: &[f64],
        out: &mut Equations,
    );
}
