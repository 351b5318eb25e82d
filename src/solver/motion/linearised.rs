//! Equations of motion linearised about a state, in independent coordinates.

use nalgebra::{DMatrix, DVector};

use super::coordinates::Coordinates;
use super::error::MotionFailure;
use super::freedoms::FreedomBases;
use crate::linear::Levels;
use crate::mechanics::eigen::singular_values;
use crate::system::{Parameters, Scratch, State, System};

/// Linearised equations of motion `E u' = F u + B w`, where u = (y, v, s), and w is added to the values of the VARIABLEs. E and F are
/// square with the size of u.
///
/// y are the coordinates, v their rates, and s the dynamic states. Small motions of the parts follow from [`FreedomBases`]: `d = Z y`,
/// `dV = V v + U y`, `dA = V v' + U y' + V' v + U' y`. The force balances, projected onto directions without constraint forces, give v'.
/// VARIABLEs are eliminated. Nonholonomic constraints leave fewer free velocities than free positions; v then has fewer components than y.
pub(super) struct Linearised {
    pub E: DMatrix<f64>,
    pub F: DMatrix<f64>,
    /// Input matrix: one row per component of u, and one column per VARIABLE for the value w added to it.
    pub B: DMatrix<f64>,
    /// Derivatives of the VARIABLEs (rows) with respect to u (columns).
    pub by_u: DMatrix<f64>,
    /// Derivatives of the VARIABLEs (rows) with respect to u' (columns).
    pub by_rate: DMatrix<f64>,
    /// Derivatives of the VARIABLEs (rows) with respect to the values w added to them (columns).
    pub by_input: DMatrix<f64>,
    /// Basis Z of the small motions of the parts, `d = Z y`: one row per part unknown, one column per coordinate.
    pub Z: DMatrix<f64>,
    /// Number of components of v, the rates of the coordinates.
    pub rates: usize,
    /// Length factor of each unknown of the parts: 1 for a translation, the model's length for a rotation.
    pub lengths: DVector<f64>,
    /// Indices of the candidate coordinates that y consists of; empty for an orthonormal basis.
    pub chosen: Vec<usize>,
    /// Indices of the candidate coordinates whose rates v consists of; empty for an orthonormal basis.
    pub chosen_rates: Vec<usize>,
}

impl Linearised {
    /// Linearises about a state at rest in equilibrium, or about a moving state that satisfies the constraints at all three levels. If `damped`
    /// is false, the derivatives of forces with respect to velocities are omitted. If `coordinates` is `None`, an orthonormal basis is used,
    /// which is possible only for a state at rest.
    ///
    /// # Errors
    /// Returns [`MotionFailure`] if an element has no value.
    pub(crate) fn new(
        system: &System,
        parameters: &Parameters,
        state: &State,
        damped: bool,
        coordinates: Option<&Coordinates>,
    ) -> Result<Self, MotionFailure> {
        let mut state = state.clone();
        state.set_moving();
        let (n, m) = (system.first_equation, system.moving_unknowns);
        let variable = system.first_variable;
        let first_state = system.first_state();
        let (unknown, states) = (first_state - variable, m - first_state);
        let variables = system.variables.len();
        let mut scratch = Scratch::new(system);
        // Surfaces at rest stick, as they do in a motion that starts from this state.
        system.advance_stiction(parameters, &mut state, &mut scratch);
        let mut levels = Levels::new(m);
        let mut g = vec![0.0; m];
        system.assemble(parameters, &state, &mut scratch, &mut g, &mut levels)?;
        levels.finish();
        // The rows for the values of the VARIABLEs, and the columns for the values added to them, follow the unknowns.
        let whole = m + variables;
        let mut J = [
            DMatrix::zeros(whole, whole),
            DMatrix::zeros(whole, whole),
            DMatrix::zeros(whole, whole),
        ];
        for (row, column, values) in levels.entries() {
            for level in 0..3 {
                J[level][(row, column)] += values[level];
            }
        }
        for (row, column, level, value) in
            system.variables_linearised(parameters, &state, &mut scratch)?
        {
            J[level][(row, column)] += value;
        }
        if !damped {
            let view = (0..n, 0..n);
            J[1].view_range_mut(view.0, view.1).fill(0.0);
        }
        let lengths = DVector::from_fn(n, |k, _| length_of(system, k));
        let free = FreedomBases::of(system, parameters, &state, coordinates, &lengths)?;
        let FreedomBases { Z, V: R, U, .. } = &free;
        // p is the number of coordinates y, and r is the number of rates v.
        let (p, r) = (Z.ncols(), R.ncols());
        let part = |level: usize, rows: (usize, usize), columns: (usize, usize)| {
            J[level]
                .view((rows.0, columns.0), (rows.1, columns.1))
                .into_owned()
        };
        let (B, V, S) = ((0, n), (variable, unknown), (first_state, states));
        let O = (m, variables);
        // VARIABLEs that are unknowns are eliminated: dv = -J_vv^-1 (J_vq dq + J_vV dV + J_vs ds + J_vw dw).
        let follow = part(0, V, V)
            .try_inverse()
            .unwrap_or_else(|| DMatrix::identity(unknown, unknown));
        let reduced = |level: usize, rows: (usize, usize), columns: (usize, usize)| {
            part(level, rows, columns) - part(0, rows, V) * &follow * part(level, V, columns)
        };
        let (K, C, M) = (reduced(0, B, B), reduced(1, B, B), -reduced(2, B, B));
        // Directions along which no multiplier acts. With friction, they differ from the directions that the constraints leave free.
        let by_multipliers = reduced(0, B, (n, variable - n));
        let N = if system.has_friction() {
            unreached(&by_multipliers, r, &lengths)
        } else {
            None
        };
        let Nt = N.as_ref().unwrap_or(R).transpose();
        let size = p + r + states;
        let (mut E, mut F) = (DMatrix::identity(size, size), DMatrix::zeros(size, size));
        let mut input = DMatrix::zeros(size, variables);
        let put = |to: &mut DMatrix<f64>, row: usize, column: usize, block: &DMatrix<f64>| {
            to.view_mut((row, column), block.shape()).copy_from(block);
        };
        put(&mut F, 0, 0, &free.of_places);
        put(&mut F, 0, p, &free.of_rates);
        put(&mut E, p, 0, &(&Nt * &M * U));
        put(&mut E, p, p, &(&Nt * &M * R));
        let by_place = &K * Z + &C * U - &M * &free.U_rate;
        put(&mut F, p, 0, &(&Nt * by_place));
        put(&mut F, p, p, &(&Nt * (&C * R - &M * &free.V_rate)));
        put(&mut input, p, 0, &(&Nt * reduced(0, B, O)));
        let s = p + r;
        if states > 0 {
            put(&mut F, p, s, &(&Nt * reduced(0, B, S)));
            let (by_place, by_rate) = (reduced(0, S, B), reduced(1, S, B));
            put(&mut F, s, 0, &(&by_place * Z + &by_rate * U));
            put(&mut F, s, p, &(&by_rate * R));
            put(&mut F, s, s, &reduced(0, S, S));
            put(&mut E, s, s, &-part(1, S, S));
            put(&mut input, s, 0, &reduced(0, S, O));
        }
        // Derivatives with respect to positions, velocities, accelerations, states and rates of states.
        let mut by_u = DMatrix::zeros(variables, size);
        let mut by_rate = DMatrix::zeros(variables, size);
        let along = |level: usize| reduced(level, O, B);
        let by_place = along(0) * Z + along(1) * U + along(2) * &free.U_rate;
        put(&mut by_u, 0, 0, &by_place);
        put(&mut by_u, 0, p, &(along(1) * R + along(2) * &free.V_rate));
        put(&mut by_rate, 0, 0, &(along(2) * U));
        put(&mut by_rate, 0, p, &(along(2) * R));
        if states > 0 {
            put(&mut by_u, 0, s, &reduced(0, O, S));
            put(&mut by_rate, 0, s, &reduced(1, O, S));
        }
        Ok(Self {
            E,
            F,
            B: input,
            by_u,
            by_rate,
            by_input: reduced(0, O, O),
            rates: r,
            lengths,
            chosen: free.chosen,
            chosen_rates: free.chosen_rates,
            Z: free.Z,
        })
    }
}

/// Returns `count` directions, as columns, along which no multiplier contributes to the force balances.
fn unreached(
    by_multipliers: &DMatrix<f64>,
    count: usize,
    lengths: &DVector<f64>,
) -> Option<DMatrix<f64>> {
    let n = by_multipliers.nrows();
    let columns = by_multipliers.ncols().max(n);
    let scaled = DMatrix::from_fn(columns, n, |k, i| {
        if k < by_multipliers.ncols() {
            by_multipliers[(i, k)] / lengths[i]
        } else {
            0.0
        }
    });
    let Vt = singular_values(scaled, false, true)?.v_t?;
    let last = Vt.nrows() - 1;
    Some(DMatrix::from_fn(n, count, |i, j| {
        Vt[(last - j, i)] / lengths[i]
    }))
}

fn length_of(system: &System, unknown: usize) -> f64 {
    let at = system
        .bodies
        .partition_point(|b| b.first + b.freedoms <= unknown);
    if unknown - system.bodies[at].first < 3 {
        1.0
    } else {
        system.length
    }
}
