//! The derivatives of the equations of motion at a state, and a stage of a step solved with them.
//!
//! A stage whose rates are z times what changes: `z dd - dW + D G' dmu = -r1`, `K dd + C dW + z N dW + ... = -g`, `G dd = -r3`,
//! `G dW = -r4` (what stands for what: [`super::newton`]). A constraint of velocities alone has neither of the last two but a row like those
//! of the balances, `f_q dd + f_V dW = -f`.

use std::ops::{Div, Mul};

use super::bordered::{Bordered, plain_weight};
use crate::linear::{Entries, Levels, Lu, Scalar};
use crate::system::{NoValue, Parameters, Rows, Scratch, State, System};

/// What a correction changes.
pub(super) struct Correction<T> {
    pub z: Vec<T>,
    pub w: Vec<T>,
    pub mu: Vec<T>,
}

/// Derivatives of all equations, gradients of the constraints and the factors of their projection.
#[derive(Clone, Debug)]
pub(super) struct Linearisation {
    pub levels: Levels,
    rows: Rows,
    bordered: Bordered,
}

impl Linearisation {
    pub(crate) fn new(system: &System) -> Self {
        Self {
            levels: Levels::new(system.moving_unknowns),
            rows: Rows::new(system),
            bordered: Bordered::new(system),
        }
    }

    /// Takes the derivatives at a state; `g` is memory for the residuals.
    pub(crate) fn take(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        g: &mut [f64],
    ) -> Result<(), NoValue> {
        self.levels.clear();
        system.assemble(parameters, state, scratch, g, &mut self.levels)?;
        self.levels.finish();
        system.constraints_and_rows(parameters, state, scratch, g, &mut self.rows)?;
        let plain = plain_weight(system);
        let holds = |k: usize| system.holds_places(state, k);
        self.bordered.factor(system, &self.rows, holds, |_| plain);
        Ok(())
    }

    /// The matrix of z over the step.
    pub(crate) fn matrix<'a, T: Scalar>(
        &'a self,
        system: &System,
        values: &'a mut Vec<T>,
        z: T,
    ) -> Entries<'a, T> {
        let (n, variable) = (system.first_equation, system.first_variable);
        let first_state = variable + system.variables.len();
        let (zero, one) = (T::default(), T::ONE);
        let inverse = one / z;
        let square = inverse * inverse;
        self.levels.combined(values, |row, column| {
            if (n..variable).contains(&row) {
                if system.of_velocities[row - n] {
                    // Its row times z.
                    if column < n {
                        [inverse, one, zero]
                    } else if column < variable {
                        [one, zero, zero]
                    } else {
                        [z, zero, zero]
                    }
                } else if column < variable {
                    [one, zero, zero]
                } else {
                    [z * z, zero, zero]
                }
            } else if column < n {
                [square, inverse, one]
            } else if column < first_state {
                [one, zero, zero]
            } else {
                [one, z, zero]
            }
        })
    }

    /// The correction by z over the step, with the factors of its matrix.
    pub(crate) fn solve<T>(
        &self,
        (system, start): (&System, &State),
        z: T,
        (r1, g, r4): (&[T], &[T], &[T]),
        factors: &mut Lu<T>,
    ) -> Correction<T>
    where
        T: Scalar + Mul<f64, Output = T> + Div<f64, Output = T>,
    {
        let n = system.first_equation;
        let mut border = self.velocity_side(system, start, z, (r1, g, r4));
        self.bordered.solve_into(&mut border);
        let e: Vec<T> = r1.iter().zip(&border).map(|(r, x)| *r - *x).collect();
        let mut b = self.right_side(system, start, z, g, &e);
        factors.solve(&mut b);
        let inverse = T::ONE / (z * z);
        let mut w = Vec::with_capacity(n);
        for k in 0..n {
            b[k] = b[k] * inverse;
            w.push(z * b[k] + e[k]);
        }
        let mu = border[n..].to_vec();
        Correction { z: b, w, mu }
    }

    /// The right side of `[ D^-1, G'; G, 0 ] [ -D G' dmu; dmu ] = [ 0; -(z r3 - r4 - G r1) ]`.
    fn velocity_side<T: Scalar>(
        &self,
        system: &System,
        start: &State,
        z: T,
        (r1, g, r4): (&[T], &[T], &[T]),
    ) -> Vec<T> {
        let n = system.first_equation;
        let mut border = vec![T::default(); n + system.equations];
        for k in 0..system.equations {
            border[n + k] = r4[k] - z * g[n + k];
        }
        for &(row, column, value) in &self.rows.entries {
            border[n + row as usize] += T::of(value) * r1[column as usize];
        }
        for k in 0..system.equations {
            if !system.holds_places(start, k) {
                border[n + k] = T::default();
            }
        }
        border
    }

    /// `-g - (C + z N) e`; of the constraints `-z^2 r3`, of those of velocities `-z (f + f_V e)`, of removed ones as they are.
    fn right_side<T: Scalar>(
        &self,
        system: &System,
        start: &State,
        z: T,
        g: &[T],
        e: &[T],
    ) -> Vec<T> {
        let (n, variable) = (system.first_equation, system.first_variable);
        let mut b: Vec<T> = g.iter().map(|g| -*g).collect();
        for k in 0..system.equations {
            if system.holds_places(start, k) {
                b[n + k] = b[n + k] * z * z;
            } else if system.takes_part(start, k) {
                b[n + k] = b[n + k] * z;
            }
        }
        for (row, column, [by_rate, by_second]) in self.levels.rates() {
            if column >= n {
                continue;
            }
            if !(n..variable).contains(&row) {
                b[row] -= (T::of(by_rate) + z * T::of(by_second)) * e[column];
            } else if system.of_velocities[row - n] {
                b[row] -= z * T::of(by_rate) * e[column];
            }
        }
        b
    }
}
