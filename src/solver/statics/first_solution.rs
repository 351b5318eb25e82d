//! Initial values of reactions, variables and states, for functions that are undefined before these values are known.

use super::newton::Solver;
use crate::system::{NoValue, Parameters, State, System};

impl Solver {
    /// Finds initial values of reactions, variables and states. Before the first solution, all of them are zero, so functions that divide by them are
    /// undefined. The parts stay in place, and functions without a value count as zero. All other unknowns follow from the linearised equations. The
    /// computation is repeated as long as further functions get a value.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this configuration.
    pub(super) fn give_values(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
    ) -> Result<(), NoValue> {
        if !system.reads_solution() {
            return Ok(());
        }
        let (_, mut lacking) = system.evaluate_leniently(parameters, state, &mut self.scratch)?;
        while lacking > 0 {
            self.next.clear();
            let (scratch, g, next) = (&mut self.scratch, &mut self.g, &mut self.next);
            system.assemble_leniently(parameters, state, scratch, g, next)?;
            self.next.finish();
            self.matrix.factor(&self.next);
            // These factors are not the tangent of an equilibrium.
            self.poses.clear();
            for (dx, g) in self.dx.iter_mut().zip(&self.g) {
                *dx = -g;
            }
            self.matrix.solve(&mut self.dx);
            self.dx[..system.first_equation].fill(0.0);
            let mut trial = state.clone();
            system.advance(&mut trial, &self.dx);
            let (_, still) = system.evaluate_leniently(parameters, &trial, &mut self.scratch)?;
            if still >= lacking {
                break;
            }
            *state = trial;
            lacking = still;
            // Continuation starts from this state, too.
            self.start.clone_from(state);
        }
        Ok(())
    }
}
