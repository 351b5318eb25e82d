//! Selection of the redundant constraint equations, revised as the mechanism moves.

use super::bordered::plain_weight;
use super::consistent::Consistent;
use super::error::MotionFailure;
use crate::system::{Parameters, State, System};

/// Largest coefficient, between gradients of unit length, with which a removed equation may depend on a kept one. Removed equations agree with
/// the others within 1e-6 of the model's length when they are selected, and must hold within 1e-4 everywhere. The limits differ by
/// a factor of 100. This coefficient may raise a violation by a factor of 10, which leaves a factor of 10 for the motion during a time step.
const EXCHANGED: f64 = 10.0;

impl Consistent {
    /// Exchanges kept constraint equations for removed ones that condition the constraints better. Returns true if any were exchanged.
    ///
    /// The gradient of a removed equation is a linear combination of the others, `g_d = sum c_k g_k`. The violation of the removed equation is
    /// therefore the same combination of their violations. A removed and a kept equation change places if the magnitude of their coefficient c,
    /// for gradients of unit length, exceeds 10. An example is `Zi.Yj` of a crank that has turned by 90 degrees: its gradient vanishes there,
    /// whereas the gradient of `Zi.Xj` does not. Each exchange multiplies the volume of the kept gradients by c (S. Goreinov, E. Tyrtyshnikov, The
    /// maximal-volume concept in approximation by low-rank matrices, Contemporary Mathematics 280, 2001). Scalar products are exchanged only for
    /// scalar products, and distances only for distances.
    ///
    /// # Errors
    /// Returns [`MotionFailure`] if a function has no value.
    pub(super) fn exchange_equations(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
    ) -> Result<bool, MotionFailure> {
        if !self.look_at_removed(system, parameters, state)? {
            return Ok(false);
        }
        let plain = plain_weight(system);
        let n = system.first_equation;
        let kinds = system.exchangeable();
        let mut gradients = vec![Vec::new(); system.equations];
        for &(row, column, value) in &self.rows.entries {
            gradients[row as usize].push((column as usize, value));
        }
        let weights: Vec<f64> = system
            .bodies
            .iter()
            .flat_map(|body| (0..body.freedoms).map(|k| plain[(k, k)]))
            .collect();
        let lengths: Vec<f64> = gradients
            .iter()
            .map(|row| {
                let squares = row.iter().map(|(column, by)| by * by / weights[*column]);
                squares.sum::<f64>().sqrt()
            })
            .collect();
        let mut exchanged = false;
        // Every exchange increases the volume, so no exchange is ever undone.
        for _ in 0..system.equations {
            let holds = |k: usize| system.is_effective_holonomic(state, k);
            self.bordered.factor(system, &self.rows, holds, |_| plain);
            let mut most = (EXCHANGED, None);
            for out in (0..system.equations).filter(|&k| state.redundant[k]) {
                let active = system.equation_is_active(out) && !system.is_nonholonomic[out];
                let Some(kind) = kinds[out].filter(|_| active && lengths[out] > 0.0) else {
                    continue;
                };
                self.border.fill(0.0);
                for &(column, by) in &gradients[out] {
                    self.border[column] += by;
                }
                self.bordered.solve(&mut self.border);
                for kept in (0..system.equations).filter(|&k| holds(k)) {
                    let share = self.border[n + kept].abs() * lengths[kept] / lengths[out];
                    if kinds[kept] == Some(kind) && share > most.0 {
                        most = (share, Some((out, kept)));
                    }
                }
            }
            let Some((out, kept)) = most.1 else {
                break;
            };
            state.redundant[out] = false;
            state.redundant[kept] = true;
            state.multipliers[kept] = 0.0;
            exchanged = true;
        }
        Ok(exchanged)
    }
}
