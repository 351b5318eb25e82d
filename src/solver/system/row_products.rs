//! Products of the constraint Jacobian with velocities and multipliers. The rows of the Jacobian are not stored, because a time integration
//! needs only these products, at every stage.

use super::{NoValue, Parameters, Scratch, State, System};
use crate::linear::Sink;

/// Products `G V + time` and `G' mu`, accumulated while the equations are assembled. G is the constraint Jacobian, V are the part
/// velocities, and `time` is the derivative of the constraints with respect to time.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowProducts {
    /// Velocities of the parts, in the order of the unknowns.
    pub v: Vec<f64>,
    /// Multiplier vector, one entry per constraint equation.
    mu: Vec<f64>,
    /// Rate of every constraint equation, `G V + time`.
    pub rates: Vec<f64>,
    /// Generalised forces `G' mu`, one entry per degree of freedom of the parts.
    pub pull: Vec<f64>,
    first_equation: usize,
    first_variable: usize,
    unknowns: usize,
    /// Whether each constraint equation is nonholonomic. The gradient of a nonholonomic equation is taken with respect to the velocities.
    of_velocities: Vec<bool>,
    /// Derivatives of the constraint equations with respect to variables and states: (row, unknown, derivative).
    others: Vec<(u32, u32, f64)>,
}

impl RowProducts {
    /// Creates zero products for a system.
    pub(crate) fn new(system: &System) -> Self {
        Self {
            mu: vec![0.0; system.equations],
            rates: vec![0.0; system.equations],
            pull: vec![0.0; system.first_equation],
            first_equation: system.first_equation,
            first_variable: system.first_variable,
            unknowns: system.moving_unknowns,
            of_velocities: system.is_nonholonomic.clone(),
            ..Self::default()
        }
    }

    fn take(&mut self, row: usize, column: usize, value: f64) {
        self.rates[row] += value * self.v[column];
        self.pull[column] += value * self.mu[row];
    }
}

impl Sink for RowProducts {
    const NEEDS_ENTRIES: bool = false;
    const ROWS: bool = true;

    fn add(&mut self, row: usize, column: usize, value: f64) {
        if row < self.first_equation || row >= self.first_variable {
            return;
        }
        let row = row - self.first_equation;
        if self.of_velocities[row] {
            let column = column.wrapping_sub(self.unknowns);
            if column < self.first_equation {
                self.take(row, column, value);
            }
        } else if column < self.first_equation {
            self.take(row, column, value);
        } else if column >= 3 * self.unknowns {
            self.rates[row] += value;
        } else if column >= self.first_variable && value != 0.0 {
            let variable = column - self.first_variable;
            self.others.push((row as u32, variable as u32, value));
        }
    }

    #[inline]
    fn add_reaction(&mut self, multiplier: usize, first: usize, column: &[f64]) {
        let row = multiplier - self.first_equation;
        let mu = self.mu[row];
        let range = first..first + column.len();
        let (v, pull) = (&self.v[range.clone()], &mut self.pull[range]);
        let mut rate = 0.0;
        for ((value, v), pull) in column.iter().zip(v).zip(pull) {
            rate += value * v;
            *pull -= value * mu;
        }
        self.rates[row] -= rate;
    }
}

impl System {
    /// Computes the residuals of all equations, including rates if the state moves. Also computes the products of the constraint Jacobian
    /// with the velocities of the state and with `mu`.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element has no value in this state.
    pub(crate) fn residual_and_products(
        &self,
        parameters: &Parameters,
        state: &State,
        mu: &[f64],
        scratch: &mut Scratch,
        g: &mut [f64],
        products: &mut RowProducts,
    ) -> Result<(), NoValue> {
        self.velocity_vector(state, &mut products.v);
        products.mu.copy_from_slice(mu);
        products.rates.fill(0.0);
        products.pull.fill(0.0);
        products.others.clear();
        self.assemble(parameters, state, scratch, g, products)?;
        self.at(parameters, state, scratch)
            .stage_rates(&mut products.rates, &products.others);
        Ok(())
    }
}
