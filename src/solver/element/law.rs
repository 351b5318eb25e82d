//! Interface of a force law. The module is independent of any particular law and of the part coordinates.

use super::Degenerate;
use crate::mechanics::{Mat6, RelativeMotion, Vec6};

/// Wrench on marker I at the I origin, in J axes, with its derivatives.
///
/// The opposite wrench acts on J at the I origin. Moved to the J origin, it is `-F` and `-T - d x F` (`state_bushing`).
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Wrench {
    /// Force and torque (first and last three components).
    pub value: Vec6,
    /// Derivative with respect to (change of `p_ij_j`, rotation `dtheta` in J axes with `R_ji <- exp(dtheta) R_ji`).
    pub by_motion: Mat6,
    /// Derivative with respect to the rates of the six components of the relative motion. Set only for an element with damping in motion,
    /// otherwise left unchanged.
    pub by_rate: Mat6,
    /// Derivative with respect to each parameter of the law. The length is the law's parameter count. Left unchanged unless parameter
    /// derivatives are requested.
    pub by_parameter: Vec<Vec6>,
}

impl Wrench {
    /// Sets the wrench and its derivatives to zero. `by_parameter` then holds one zero column.
    pub(crate) fn clear(&mut self) {
        self.value = Vec6::zeros();
        self.by_motion = Mat6::zeros();
        self.parameter_columns(1);
    }

    /// Resizes `by_parameter` to `count` zero columns and returns them. Allocates only on the first call.
    pub(super) fn parameter_columns(&mut self, count: usize) -> &mut [Vec6] {
        self.by_parameter.clear();
        self.by_parameter.resize(count, Vec6::zeros());
        &mut self.by_parameter
    }
}

/// Force law between two markers.
pub(crate) trait Law: std::fmt::Debug + Send + Sync {
    /// Returns the number of entries of `theta` that this law reads.
    fn parameter_count(&self) -> usize;

    /// Returns whether the law reads `RelativeMotion::angles`. If not, the caller may leave these angles uncomputed.
    fn uses_angles(&self) -> bool {
        true
    }

    /// Computes the wrench and `by_motion` at a relative motion, and also `by_parameter` if `with_parameters` is set. `theta` holds the
    /// law's parameters in the order of its arguments (`law` in the grammar). `out` is reused: implementations overwrite every field they
    /// compute.
    ///
    /// # Errors
    /// Returns [`Degenerate`] where the law is undefined at this motion; `out` is then unspecified.
    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        with_parameters: bool,
        out: &mut Wrench,
    ) -> Result<(), Degenerate>;

    /// Returns the elastic energy if the law has a potential. A preload contributes as a constant (dead) load.
    #[cfg(test)]
    fn energy(&self, _motion: &RelativeMotion, _theta: &[f64]) -> Option<f64> {
        None
    }
}
