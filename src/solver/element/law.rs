//! What a force law is. Knows no particular law and no part coordinates.

use super::Degenerate;
use crate::mechanics::{Mat6, RelativeMotion, Vec6};

/// The wrench on marker I at the I origin, in J axes, and its derivatives.
///
/// J feels the opposite force at the I origin, that is `-F` and `-T - d x F` at the J origin (`state_bushing`).
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Wrench {
    /// (force, torque).
    pub value: Vec6,
    /// Derivative by (change of `p_ij_j`, rotation `dtheta` in J axes with `R_ji <- exp(dtheta) R_ji`).
    pub by_motion: Mat6,
    /// Derivative by the rates of the same; of an element with damping that moves, else left alone.
    pub by_rate: Mat6,
    /// Derivative by each parameter of the law; as long as the law's parameter list when asked for, else left alone.
    pub by_parameter: Vec<Vec6>,
}

impl Wrench {
    /// No wrench: zero, with a column for one parameter.
    pub(crate) fn clear(&mut self) {
        self.value = Vec6::zeros();
        self.by_motion = Mat6::zeros();
        self.parameter_columns(1);
    }

    /// Zeroed columns for `count` parameters. Allocates only the first time.
    pub(super) fn parameter_columns(&mut self, count: usize) -> &mut [Vec6] {
        self.by_parameter.clear();
        self.by_parameter.resize(count, Vec6::zeros());
        &mut self.by_parameter
    }
}

/// A force law between two markers.
pub(crate) trait Law: std::fmt::Debug + Send + Sync {
    /// How many numbers of `theta` are this law's.
    fn parameter_count(&self) -> usize;

    /// Whether `RelativeMotion::angles` is read; if not, the caller need not work it out.
    fn uses_angles(&self) -> bool {
        true
    }

    /// Wrench and `by_motion` at this motion; `by_parameter` too when `with_parameters`. `theta` holds the law's parameters in
    /// the order of its arguments (`law` in the grammar). `out` is reused: implementations overwrite every field they return.
    ///
    /// # Errors
    /// [`Degenerate`] where the law has no value at this motion; `out` is then unspecified.
    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        with_parameters: bool,
        out: &mut Wrench,
    ) -> Result<(), Degenerate>;

    /// Elastic energy, where the law has a potential; preloads count as dead loads of the deflection.
    #[cfg(test)]
    fn energy(&self, _motion: &RelativeMotion, _theta: &[f64]) -> Option<f64> {
        None
    }
}
