//! Derivatives of the equations of motion at a state, and the linear system of one stage of a step, which is solved with them.
//!
//! In the linear system of a stage, rates are z times changes: `z dd - dW + D G' dmu = -r1`, `K dd + C dW + z N dW + ... = -g`, `G dd = -r3`,
//! `G dW = -r4`. The notation is explained in [`super::newton`]. For a nonholonomic constraint, one equation replaces the last two. It
//! resembles a force balance: `f_q dd + f_V dW = -f`.

use std::ops::{Div, Mul};

use super::bordered::{Bordered, plain_weight};
use crate::linear::{Entries, Levels, Lu, Scalar};
use crate::system::{NoValue, Parameters, Rows, Scratch, State, System};

/// Residuals of the equations of a stage. The solution replaces them by the changes of the unknowns.
#[derive(Clone, Debug, Default)]
pub(super) struct Correction<T> {
    /// Before the solution, residuals of force balances, constraints and states. After it, changes of displacements, multipliers, variables and
    /// states.
    pub z: Vec<T>,
    /// Before the solution, residuals of the rates of displacements. After it, changes of velocities.
    pub w: Vec<T>,
    /// Before the solution, residuals of the velocity constraints. After it, changes of the multipliers of these constraints.
    pub mu: Vec<T>,
    border: Vec<T>,
    found: Vec<T>,
}

impl<T: Scalar> Correction<T> {
    /// Creates a correction from the residuals g, r1 and r4.
    pub(crate) fn of(z: Vec<T>, w: Vec<T>, mu: Vec<T>) -> Self {
        Self {
            z,
            w,
            mu,
            ..Self::default()
        }
    }
}

/// Derivatives of all equations at a state, the constraint gradients, and the factors of the projection onto the constraints.
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
            bordered: Bordered::plain(system),
        }
    }

    /// Evaluates the derivatives and factors the projection at a state. `g` is work space for the residuals.
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
        let holds = |k: usize| system.is_effective_holonomic(state, k);
        self.bordered.factor(system, &self.rows, holds, |_| plain);
        self.rows.pack();
        Ok(())
    }

    /// Returns the matrix of a stage. `z` is the coefficient of the stage (for example an eigenvalue of B) divided by the step size.
    pub(crate) fn matrix<'a, T: Scalar>(
        &'a self,
        system: &System,
        values: &'a mut Vec<T>,
        z: T,
    ) -> Entries<'a, T> {
        let (n, variable) = (system.first_equation, system.first_variable);
        let first_state = system.first_state();
        let (zero, one) = (T::default(), T::ONE);
        let inverse = one / z;
        let square = inverse * inverse;
        self.levels.combined(values, |row, column| {
            if (n..variable).contains(&row) {
                if system.is_nonholonomic[row - n] {
                    // The row is multiplied by z.
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

    /// Replaces the residuals in `of` by the changes of the unknowns. `factors` must be the factors of [`Self::matrix`] for the same `z`.
    pub(crate) fn solve<T, F>(
        &self,
        system: &System,
        start: &State,
        z: T,
        of: &mut Correction<T>,
        factors: &Lu<F>,
    ) where
        T: Scalar + Mul<f64, Output = T> + Div<f64, Output = T>,
        T: Mul<F, Output = T> + Div<F, Output = T>,
        F: Scalar,
    {
        self.velocity_side(system, start, z, of);
        of.found.clear();
        of.found.resize(of.border.len(), T::default());
        self.bordered.solve_into(&mut of.border, &mut of.found);
        for (e, x) in of.w.iter_mut().zip(&of.found) {
            *e -= *x;
        }
        of.mu.copy_from_slice(&of.found[system.first_equation..]);
        self.right_side(system, start, z, of);
        of.found.resize(system.moving_unknowns, T::default());
        factors.solve_into(&mut of.z, &mut of.found);
        let inverse = T::ONE / (z * z);
        of.z.copy_from_slice(&of.found);
        for (x, e) in of.z.iter_mut().zip(&mut of.w) {
            *x = *x * inverse;
            *e = z * *x + *e;
        }
    }

    /// Computes the right side of `[ D^-1, G'; G, 0 ] [ -D G' dmu; dmu ] = [ 0; -(z r3 - r4 - G r1) ]`.
    fn velocity_side<T: Scalar>(
        &self,
        system: &System,
        start: &State,
        z: T,
        of: &mut Correction<T>,
    ) {
        let n = system.first_equation;
        of.border.clear();
        of.border.resize(n + system.equations, T::default());
        for k in 0..system.equations {
            of.border[n + k] = of.mu[k] - z * of.z[n + k];
        }
        for &(row, column, value) in &self.rows.entries {
            of.border[n + row as usize] += T::of(value) * of.w[column as usize];
        }
        for k in 0..system.equations {
            if !system.is_effective_holonomic(start, k) {
                of.border[n + k] = T::default();
            }
        }
    }

    /// Computes the right side of the main linear system. It is `-g - (C + z N) e` for force balances and states, `-z^2 r3` for holonomic
    /// constraints, `-z (f + f_V e)` for nonholonomic constraints, and `-g` for removed equations.
    fn right_side<T: Scalar>(&self, system: &System, start: &State, z: T, of: &mut Correction<T>) {
        let (n, variable) = (system.first_equation, system.first_variable);
        let (b, e) = (&mut of.z, &of.w);
        for g in b.iter_mut() {
            *g = -*g;
        }
        for k in 0..system.equations {
            if system.is_effective_holonomic(start, k) {
                b[n + k] = b[n + k] * z * z;
            } else if system.is_effective(start, k) {
                b[n + k] = b[n + k] * z;
            }
        }
        for (row, column, [by_rate, by_second]) in self.levels.rates() {
            if column >= n {
                continue;
            }
            if !(n..variable).contains(&row) {
                b[row] -= (T::of(by_rate) + z * T::of(by_second)) * e[column];
            } else if system.is_nonholonomic[row - n] {
                b[row] -= z * T::of(by_rate) * e[column];
            }
        }
    }
}
