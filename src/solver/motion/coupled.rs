//! Newton iteration on the three stages of a step together, each stage with its own derivatives.
//!
//! The simplified iteration of [`super::newton`] uses the derivatives of one stage for all three. Near a singular position of the mechanism,
//! the constraint gradients change by as much as their own size within a step. No step is then short enough for the simplified iteration. The
//! coupled iteration converges there, but its matrix has three times as many unknowns.
//!
//! The unknowns of a stage are y, dW and dmu. y contains the displacements and rotations at the stage, the multipliers, variables and states.
//! dW contains the velocities, and dmu the multipliers of the velocity constraints. P is the identity for translations and
//! [`turning_rate`](crate::mechanics::turning_rate) for rotations. With `dd = P y`, the equations of stage i are:
//!
//! ```text
//! K_i y_i + C_i dW_i + N_i sum_j B_ij/h dW_j = -g_i
//! sum_j B_ij/h P_j y_j - P_i (dW_i - D G_i' dmu_i) = -r1_i
//! G_i dW_i = -r4_i
//! ```

use super::bordered::plain_weight;
use super::newton::{Step, StepMatrices, Unknowns, turns};
use crate::linear::{Levels, Lu, Matrix, Occupied, Sink, by_groups};
use crate::mechanics::{Mat3, Vec3};
use crate::system::{NoValue, Parameters, Rows, System};

/// Matrix of the iteration and its factors. The pattern of the matrix stays the same.
#[derive(Debug)]
pub(super) struct Coupled {
    matrix: Matrix,
    occupied: Occupied,
    values: Vec<f64>,
    factors: Lu,
    levels: Levels,
    rows: Rows,
    g: Vec<f64>,
    /// For each unknown of the three-stage system, the index of the same unknown in the equations of motion. The three copies of an unknown form
    /// a group.
    groups: Vec<u32>,
}

impl Coupled {
    pub(crate) fn new(system: &System) -> Self {
        let (n, all) = (system.first_equation, system.moving_unknowns);
        let of_a_stage = (0..all).chain(0..n).chain(n..n + system.equations);
        let groups: Vec<u32> = (0..3)
            .flat_map(|_| of_a_stage.clone().map(|k| k as u32))
            .collect();
        let size = groups.len();
        Self {
            groups,
            matrix: Matrix::new(size),
            occupied: Occupied::default(),
            values: Vec::new(),
            // `Lu::for_steps` is not used, because its pivots may become so small that the corrections do not converge near a singular
            // position.
            factors: Lu::for_many(size),
            levels: Levels::new(system.moving_unknowns),
            rows: Rows::new(system),
            g: vec![0.0; system.moving_unknowns],
        }
    }

    /// Evaluates the derivatives of every stage and factors the matrix.
    pub(crate) fn factor(
        &mut self,
        equations: &mut StepMatrices,
        system: &System,
        parameters: &Parameters,
        step: Step<'_>,
        unknowns: &Unknowns,
    ) -> Result<(), NoValue> {
        let Step { start, h } = step;
        let (n, all, count) = (
            system.first_equation,
            system.moving_unknowns,
            system.equations,
        );
        let size = all + n + count;
        let (y, w, mu) = (
            |i: usize, k: usize| i * size + k,
            |i: usize, k: usize| i * size + all + k,
            |i: usize, k: usize| i * size + all + n + k,
        );
        let constraints = n..system.first_variable;
        let first_state = system.first_state();
        let plain = plain_weight(system);
        let turns: [Vec<Mat3>; 3] = std::array::from_fn(|i| turns(system, &unknowns.z[i]));
        let B = equations.tableau.B.map(|row| row.map(|b| b / h));
        let Coupled {
            matrix,
            occupied,
            values,
            factors,
            levels,
            rows,
            g,
            groups,
        } = self;
        matrix.clear();
        let mut put = |row: usize, column: usize, value: f64| matrix.add(row, column, value);
        for i in 0..3 {
            equations.place_stage(system, start, h, i, unknowns);
            levels.clear();
            let (stage, scratch) = (&equations.stage, &mut equations.scratch);
            system.assemble(parameters, stage, scratch, g, levels)?;
            levels.finish();
            system.constraints_and_rows(parameters, stage, scratch, g, rows)?;
            let standing = levels.standing();
            for ((row, column, [k, c, m]), [by_k, by_c, by_m]) in levels.entries().zip(standing) {
                if by_k {
                    put(y(i, row), y(i, column), k);
                }
                if constraints.contains(&row) && !system.is_nonholonomic[row - n] {
                    continue;
                }
                let of_a_body = column < n;
                if of_a_body && by_c {
                    put(y(i, row), w(i, column), c);
                }
                for j in 0..3 {
                    if of_a_body && by_m {
                        put(y(i, row), w(j, column), m * B[i][j]);
                    } else if column >= first_state && by_c {
                        put(y(i, row), y(j, column), c * B[i][j]);
                    }
                }
            }
            for (part, body) in system.bodies.iter().enumerate() {
                for a in 0..body.freedoms {
                    let at = body.first + a;
                    if a < 3 {
                        for j in 0..3 {
                            put(w(i, at), y(j, at), B[i][j]);
                        }
                        put(w(i, at), w(i, at), -1.0);
                        continue;
                    }
                    for b in 0..3 {
                        let other = body.first + 3 + b;
                        for j in 0..3 {
                            put(w(i, at), y(j, other), B[i][j] * turns[j][part][(a - 3, b)]);
                        }
                        put(w(i, at), w(i, other), -turns[i][part][(a - 3, b)]);
                    }
                }
            }
            let body_of = |column: usize| {
                let after = system.bodies.partition_point(|body| body.first <= column);
                after - 1
            };
            for &(row, column, value) in &rows.entries {
                let (row, column) = (row as usize, column as usize);
                let value = if system.is_effective_holonomic(start, row) {
                    value
                } else {
                    0.0
                };
                put(mu(i, row), w(i, column), value);
                let part = body_of(column);
                let first = system.bodies[part].first;
                let k = column - first;
                let pull = value / plain[(k, k)];
                if k < 3 {
                    put(w(i, column), mu(i, row), pull);
                } else {
                    for a in 0..3 {
                        put(
                            w(i, first + 3 + a),
                            mu(i, row),
                            turns[i][part][(a, k - 3)] * pull,
                        );
                    }
                }
            }
            for k in 0..count {
                let out = !system.is_effective_holonomic(start, k);
                put(mu(i, k), mu(i, k), f64::from(u8::from(out)));
            }
        }
        matrix.finish();
        let matrix = matrix.occupied(occupied, values);
        factors.factor_in_order(&matrix, |entries| by_groups(entries, groups));
        equations.factorisations += 1;
        equations.jacobians += 3;
        Ok(())
    }

    /// Computes the corrections of the unknowns from the residuals of the stages, with the factors computed last.
    pub(crate) fn correct(
        &mut self,
        equations: &StepMatrices,
        system: &System,
        unknowns: &Unknowns,
        change: &mut Unknowns,
    ) {
        let (n, all, count) = (
            system.first_equation,
            system.moving_unknowns,
            system.equations,
        );
        let size = all + n + count;
        let (y, w, mu) = (
            |i: usize, k: usize| i * size + k,
            |i: usize, k: usize| i * size + all + k,
            |i: usize, k: usize| i * size + all + n + k,
        );
        let turns: [Vec<Mat3>; 3] = std::array::from_fn(|i| turns(system, &unknowns.z[i]));
        let factors = &mut self.factors;
        let mut b = vec![0.0; 3 * size];
        for i in 0..3 {
            let from = equations.residuals.of(i);
            for (to, value) in b[i * size..(i + 1) * size].iter_mut().zip(from) {
                *to = -value;
            }
        }
        factors.solve(&mut b);
        for i in 0..3 {
            change.z[i].copy_from_slice(&b[y(i, 0)..y(i, all)]);
            change.w[i].copy_from_slice(&b[w(i, 0)..w(i, n)]);
            change.mu[i].copy_from_slice(&b[mu(i, 0)..mu(i, count)]);
            for (part, body) in system.bodies.iter().enumerate() {
                if body.freedoms < 6 {
                    continue;
                }
                let at = body.first + 3;
                let z = &mut change.z[i][at..at + 3];
                let turned = turns[i][part] * Vec3::new(z[0], z[1], z[2]);
                z.copy_from_slice(turned.as_slice());
            }
        }
    }
}
