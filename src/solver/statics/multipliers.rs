//! Initial values of the Lagrange multipliers.

use super::newton::Solver;
use crate::linear::{Lu, Matrix, Sink};
use crate::system::{NoValue, Parameters, State, System};

impl Solver {
    /// Sets the multipliers to the values that balance the forces best at the present positions, in the least-squares sense, with torques
    /// divided by the model's length. Returns true if the multipliers were set. If any multiplier is already nonzero, all are kept.
    ///
    /// Along a motion on curved constraints, the stiffness equals the second derivative of the energy only with these multipliers (Nocedal and
    /// Wright, Numerical Optimization, 18.3). With zero multipliers, a pendulum has no stiffness and may reach either of its two equilibria.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this configuration.
    pub(super) fn first_multipliers(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
    ) -> Result<bool, NoValue> {
        if state.multipliers.iter().any(|m| *m != 0.0) || state.multipliers.is_empty() {
            return Ok(false);
        }
        self.assemble(system, parameters, state)?;
        let (bodies, variables) = (system.first_equation, system.first_variable);
        // The matrix is [-W, G'; G, 0], where W contains the squares of the length factors. Variables and states follow the multipliers, and
        // the parts stay in place.
        let mut matrix = Matrix::new(system.unknowns());
        matrix.clear();
        for body in &system.bodies {
            for k in 0..body.freedoms {
                let length = if k < 3 { 1.0 } else { system.length };
                matrix.add(body.first + k, body.first + k, -length * length);
            }
        }
        for (row, column, value) in self.next.entries() {
            let stiffness = row < bodies && column < bodies;
            let driven = (bodies..variables).contains(&row) && column >= variables;
            let moved = row >= variables && column < bodies;
            if !stiffness && !driven && !moved {
                matrix.add(row, column, value);
            }
        }
        matrix.finish();
        let mut change: Vec<f64> = self.g_trial.iter().map(|g| -g).collect();
        change[bodies..variables].fill(0.0);
        let mut factors = Lu::new(system.unknowns());
        factors.factor(&matrix);
        factors.solve(&mut change);
        let found = &change[bodies..variables];
        if !found.iter().all(|m| m.is_finite()) {
            return Ok(false);
        }
        state.multipliers.copy_from_slice(found);
        Ok(true)
    }
}
