//! Reactions, variables and states to begin with, where functions have no value before these are known.

use super::newton::Solver;
use crate::system::{NoValue, Parameters, State, System};

impl Solver {
    /// Gives values to functions that divide by reactions or by outputs of linear states, which are zero before the first solution: the
    /// functions without a value count as zero, and the parts stay where they are while all else follows the linear solution. Again, as long as
    /// more functions have a value each time.
    ///
    /// # Errors
    /// [`NoValue`] if an element has none here.
    pub(super) fn give_values(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
    ) -> Result<(), NoValue> {
        if !system.reads_solution() {
            return Ok(());
        }
        let (_, mut lacking) = system.look_leniently(parameters, state, &mut self.scratch)?;
        while lacking > 0 {
            self.next.clear();
            let (scratch, g, next) = (&mut self.scratch, &mut self.g, &mut self.next);
            system.assemble_leniently(parameters, state, scratch, g, next)?;
            self.next.finish();
            self.matrix.factor(&self.next);
            // These factors are the tangent of no equilibrium.
            self.poses.clear();
            for (dx, g) in self.dx.iter_mut().zip(&self.g) {
                *dx = -g;
            }
            self.matrix.solve(&mut self.dx);
            self.dx[..system.first_equation].fill(0.0);
            let mut trial = state.clone();
            system.advance(&mut trial, &self.dx);
            let (_, still) = system.look_leniently(parameters, &trial, &mut self.scratch)?;
            if still >= lacking {
                break;
            }
            *state = trial;
            lacking = still;
            // Other ways to the equilibrium begin there, too.
            self.start.clone_from(state);
        }
        Ok(())
    }
}
