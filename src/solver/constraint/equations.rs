//! What a constraint between two markers is. Knows no particular one and no part coordinates.

use crate::mechanics::{Mat3, RelativeMotion, Vec6};

/// Residuals of up to six scalar equations between two markers, with derivatives in J axes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Equations {
    /// How many equations.
    pub count: usize,
    /// Residuals; the first `count` are used.
    pub residual: [f64; 6],
    /// Row k: derivative of residual k by (change of `p_ij_j`, rotation `dtheta` in J axes).
    pub jacobian: [Vec6; 6],
    /// Sum over k of `multipliers[k]` times the derivative of the rotational half of `jacobian[k]` (as a column) by `dtheta`.
    ///
    /// All other blocks of the second variation vanish: every equation is a component of `p_ij_j`, which is linear in it, plus
    /// a function of `R_ji` alone. Not symmetric in general because rotations do not commute.
    pub curvature: Mat3,
    /// Derivative of `residual[0]` by the constraint's parameter, if it has one (only one-equation constraints have).
    pub residual_by_parameter: f64,
    /// Derivative of `jacobian[0]` by the constraint's parameter.
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

/// A holonomic constraint between two markers. The wrench on I at the I origin in J axes is `-sum_k multipliers[k] * jacobian[k]`.
pub(crate) trait Constraint: std::fmt::Debug + Send + Sync {
    /// How many scalar equations.
    fn count(&self) -> usize;

    /// How many numbers of `theta` are this constraint's: zero or one (PITCH, PD, the value of a MOTION).
    fn parameter_count(&self) -> usize {
        0
    }

    /// The name of each equation as ADAMS prints it when redundant, for example `Zi.Xj`; `D` is the vector from J to I.
    fn equation_name(&self, k: usize) -> &'static str;

    /// Whether `RelativeMotion::angles` is read; if not, the caller need not work it out.
    fn uses_angles(&self) -> bool {
        false
    }

    /// Residuals, Jacobian and curvature at this motion. `out` is reused: implementations overwrite the first `count` rows,
    /// `curvature` and, if there is a parameter, its derivatives.
    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        multipliers: &[f64],
        out: &mut Equations,
    );
}
