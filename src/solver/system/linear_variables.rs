//! Linearisation of VARIABLEs: derivatives of their values, and derivatives with respect to inputs added to them.

use super::derivative::Seeded;
use super::scratch::{FunctionNumber, Seed};
use super::{NoValue, Parameters, Scratch, State, System};

/// Entry of a linearisation: row, column, level (0, 1, 2 for the unknown, its first or its second time derivative) and value.
pub(crate) type Entry = (usize, usize, usize, f64);

impl System {
    /// Returns the entries that VARIABLEs add to the linearisation of a moving state. With m unknowns, row m + k is the value of VARIABLE k
    /// in the order of the model, and column m + k is an input added to VARIABLE k.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element has no value in this state.
    pub(crate) fn variables_linearised(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<Vec<Entry>, NoValue> {
        let (m, first) = (self.moving_unknowns, self.first_seed());
        let mut out = Vec::new();
        if self.variables.is_empty() {
            return Ok(out);
        }
        let all = self.variables.iter().enumerate();
        scratch.seeds = all
            .map(|(k, variable)| Seed {
                function: variable.function,
                number: FunctionNumber::Value,
                column: first + k,
            })
            .collect();
        let found = self.entries_with_seeds(parameters, state, scratch, &mut out);
        scratch.seeds.clear();
        found?;
        debug_assert!(out.iter().all(|entry| entry.0 < m + self.variables.len()));
        Ok(out)
    }

    fn entries_with_seeds(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        out: &mut Vec<Entry>,
    ) -> Result<(), NoValue> {
        let (m, first) = (self.moving_unknowns, self.first_seed());
        let mut sink = Seeded {
            first,
            columns: vec![vec![0.0; m]; self.variables.len()],
        };
        let mut g = vec![0.0; m];
        self.assemble(parameters, state, scratch, &mut g, &mut sink)?;
        for (k, column) in sink.columns.iter().enumerate() {
            let rows = column.iter().enumerate().filter(|(_, by)| **by != 0.0);
            out.extend(rows.map(|(row, by)| (row, m + k, 0, *by)));
        }
        let mut here = self.at(parameters, state, scratch);
        for k in 0..self.variables.len() {
            // A VARIABLE without a value in this state has no derivatives.
            for (column, by) in here.variable_gradient(k).unwrap_or_default() {
                if column < 3 * m {
                    out.push((m + k, column % m, column / m, by));
                } else if column >= first {
                    out.push((m + k, m + column - first, 0, by));
                }
            }
        }
        Ok(())
    }
}
