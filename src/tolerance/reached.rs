//! The maximum of a linear model, and what is below it.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::factor::Factor;

/// The maximum of a linear model.
pub(crate) struct Reached {
    /// Logarithm of the evidence times the prior of the sizes.
    pub ln_z: f64,
    /// What the step gains, in nats.
    pub gain: f64,
    /// Step from where the model was linearised.
    pub step: DVector<f64>,
    /// Of the information in units of the priors.
    pub(super) factor: Factor,
    /// Standard deviations of the priors.
    pub(super) S: DVector<f64>,
}

impl Reached {
    /// By how many nats the maximum is above where another step leads, in the linear model.
    pub(crate) fn above(&self, other: &DVector<f64>) -> f64 {
        let off =
            (other - &self.step).zip_map(&self.S, |off, s| if s > 0.0 { off / s } else { 0.0 });
        0.5 * self.factor.quadratic(&off)
    }

    /// The step to the maximum with some unknowns moving by given amounts instead.
    pub(crate) fn step_with(&self, given: &[(usize, f64)]) -> DVector<f64> {
        if given.is_empty() {
            return self.step.clone();
        }
        let n = self.step.len();
        let mut across = DMatrix::zeros(n, given.len());
        for (k, (place, _)) in given.iter().enumerate() {
            let mut unit = DVector::zeros(n);
            unit[*place] = self.S[*place];
            let column = self.factor.solve(&unit).component_mul(&self.S);
            across.set_column(k, &column);
        }
        let places: Vec<usize> = given.iter().map(|(place, _)| *place).collect();
        let off = DVector::from_iterator(
            given.len(),
            given.iter().map(|(place, value)| value - self.step[*place]),
        );
        match Cholesky::new(across.select_rows(&places)) {
            Some(factor) => &self.step + across * factor.solve(&off),
            None => self.step.clone(),
        }
    }
}
