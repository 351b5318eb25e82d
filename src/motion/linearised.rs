//! The equations of motion linearised about a state, in coordinates that the constraints leave free.

use nalgebra::{DMatrix, DVector, RowDVector};

use super::error::Reason;
use crate::linear::Levels;
use crate::mechanics::eigen::singular_values;
use crate::mechanics::{Vec3, skew};
use crate::system::{Parameters, Rows, Scratch, State, System};

/// Singular values of the gradients below this share of the largest count as zero.
const NO_GRADIENT: f64 = 1e-9;
/// Steps of the differences of rates of constraints.
const STEP: f64 = 1e-5;

/// Which coordinates the free motions are written in.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Basis {
    /// Orthonormal, rotations times the length of the model.
    Orthonormal,
    /// Coordinates of the parts, as many as there are freedoms.
    Coordinates,
}

/// `E u' = F u + B w`, u = (y, x, s), w added to the VARIABLEs.
///
/// With Z a basis of the motions that the gradients G leave free, H the derivative of the rates G V + Phi_t by the places and X = -G^+ H,
/// small motions are d = Z y, dV = Z x + X d, `y' = Z'(X + W) Z y + x`, W the angular velocities as matrices of cross products
/// (`dphi' = dw + w x dphi`), and the balance along what no multiplier reaches gives x'. VARIABLEs follow, dynamic states s are appended.
pub(super) struct Linearised {
    pub E: DMatrix<f64>,
    pub F: DMatrix<f64>,
    /// By what is added to each VARIABLE.
    pub B: DMatrix<f64>,
    /// VARIABLEs by u, u' and what is added to them.
    pub by_u: DMatrix<f64>,
    pub by_rate: DMatrix<f64>,
    pub by_input: DMatrix<f64>,
    /// Motions of the parts by y.
    pub Z: DMatrix<f64>,
    /// One for translations, the length of the model for rotations.
    pub lengths: DVector<f64>,
    /// The unknowns of the parts that y is, in a basis of coordinates.
    pub chosen: Vec<usize>,
}

impl Linearised {
    /// About a state at rest in equilibrium, or one that moves and satisfies the constraints at all three levels. `damped` false leaves the
    /// derivatives by velocities out.
    ///
    /// # Errors
    /// [`Reason`] where an element has no value.
    pub(crate) fn new(
        system: &System,
        parameters: &Parameters,
        state: &State,
        damped: bool,
        basis: Basis,
    ) -> Result<Self, Reason> {
        let mut state = state.clone();
        state.set_moving();
        let (n, m) = (system.first_equation, system.moving_unknowns);
        let variable = system.first_variable;
        let first_state = variable + system.variables.len();
        let (variables, states) = (first_state - variable, m - first_state);
        let mut scratch = Scratch::new(system);
        let mut levels = Levels::new(m);
        let mut g = vec![0.0; m];
        system.assemble(parameters, &state, &mut scratch, &mut g, &mut levels)?;
        levels.finish();
        let mut J = [
            DMatrix::zeros(m, m),
            DMatrix::zeros(m, m),
            DMatrix::zeros(m, m),
        ];
        for (row, column, values) in levels.entries() {
            for level in 0..3 {
                J[level][(row, column)] += values[level];
            }
        }
        if !damped {
            let view = (0..n, 0..n);
            J[1].view_range_mut(view.0, view.1).fill(0.0);
        }
        let lengths = DVector::from_fn(n, |k, _| length_of(system, k));
        let (mut Z, X) = free_motions(system, parameters, &state, &lengths)?;
        let r = Z.ncols();
        let mut chosen = Vec::new();
        if basis == Basis::Coordinates && r > 0 {
            chosen = coordinates(&Z, &lengths);
            let square = DMatrix::from_fn(r, r, |i, j| Z[(chosen[i], j)]);
            if let Some(inverse) = square.try_inverse() {
                Z *= inverse;
            }
        }
        let part = |level: usize, rows: (usize, usize), columns: (usize, usize)| {
            J[level]
                .view((rows.0, columns.0), (rows.1, columns.1))
                .into_owned()
        };
        let (B, V, S) = ((0, n), (variable, variables), (first_state, states));
        // Variables follow: dv = -J_vv^-1 (J_vq dq + J_vV dV + J_vs ds - dw).
        let follow = part(0, V, V)
            .try_inverse()
            .unwrap_or_else(|| DMatrix::identity(variables, variables));
        let reduced = |level: usize, rows: (usize, usize), columns: (usize, usize)| {
            part(level, rows, columns) - part(0, rows, V) * &follow * part(level, V, columns)
        };
        let (K, C, M) = (reduced(0, B, B), reduced(1, B, B), -reduced(2, B, B));
        let mut W = DMatrix::zeros(n, n);
        for (body, velocity) in system.bodies.iter().zip(&state.velocities) {
            if body.freedoms == 6 {
                let block = skew(&velocity.angular);
                let at = body.first + 3;
                W.view_mut((at, at), (3, 3)).copy_from(&block);
            }
        }
        let XZ = &X * &Z;
        // What no multiplier reaches: with friction that is not what the constraints leave free.
        let by_multipliers = reduced(0, B, (n, variable - n));
        let N = if system.has_friction() {
            unreached(&by_multipliers, r, &lengths).unwrap_or_else(|| Z.clone())
        } else {
            Z.clone()
        };
        let Nt = N.transpose();
        let size = 2 * r + states;
        let (mut E, mut F) = (DMatrix::identity(size, size), DMatrix::zeros(size, size));
        let mut input = DMatrix::zeros(size, variables);
        let put = |to: &mut DMatrix<f64>, row: usize, column: usize, block: &DMatrix<f64>| {
            to.view_mut((row, column), block.shape()).copy_from(block);
        };
        let left = match basis {
            // The left inverse of Z, which is orthonormal where rotations are taken times the length.
            Basis::Orthonormal => {
                DMatrix::from_fn(r, n, |i, j| Z[(j, i)] * lengths[j] * lengths[j])
            }
            Basis::Coordinates => {
                DMatrix::from_fn(r, n, |i, j| f64::from(u8::from(chosen[i] == j)))
            }
        };
        put(&mut F, 0, 0, &(left * (&X + W) * &Z));
        put(&mut F, 0, r, &DMatrix::identity(r, r));
        put(&mut E, r, 0, &(&Nt * &M * &XZ));
        put(&mut E, r, r, &(&Nt * &M * &Z));
        put(&mut F, r, 0, &(&Nt * (&K * &Z + &C * &XZ)));
        put(&mut F, r, r, &(&Nt * &C * &Z));
        put(&mut input, r, 0, &(&Nt * part(0, B, V) * &follow));
        if states > 0 {
            put(&mut F, r, 2 * r, &(&Nt * reduced(0, B, S)));
            let (by_place, by_rate) = (reduced(0, S, B), reduced(1, S, B));
            put(&mut F, 2 * r, 0, &(&by_place * &Z + &by_rate * &XZ));
            put(&mut F, 2 * r, r, &(&by_rate * &Z));
            put(&mut F, 2 * r, 2 * r, &reduced(0, S, S));
            put(&mut E, 2 * r, 2 * r, &-part(1, S, S));
            put(&mut input, 2 * r, 0, &(part(0, S, V) * &follow));
        }
        // dv = follow (dw - J_v by places, velocities, accelerations, states and their rates).
        let mut by_u = DMatrix::zeros(variables, size);
        let mut by_rate = DMatrix::zeros(variables, size);
        let along = |level: usize| -(&follow * part(level, V, B));
        put(&mut by_u, 0, 0, &(along(0) * &Z + along(1) * &XZ));
        put(&mut by_u, 0, r, &(along(1) * &Z));
        put(&mut by_rate, 0, 0, &(along(2) * &XZ));
        put(&mut by_rate, 0, r, &(along(2) * &Z));
        if states > 0 {
            put(&mut by_u, 0, 2 * r, &-(&follow * part(0, V, S)));
            put(&mut by_rate, 0, 2 * r, &-(&follow * part(1, V, S)));
        }
        Ok(Self {
            E,
            F,
            B: input,
            by_u,
            by_rate,
            by_input: follow,
            Z,
            lengths,
            chosen,
        })
    }
}

/// As many rows of Z as it has columns, as independent as can be: coordinates that describe every free motion.
fn coordinates(Z: &DMatrix<f64>, lengths: &DVector<f64>) -> Vec<usize> {
    let mut left = DMatrix::from_fn(Z.nrows(), Z.ncols(), |i, j| Z[(i, j)] * lengths[i]);
    let mut chosen = Vec::new();
    for _ in 0..Z.ncols() {
        // The first of those that are equal but for round-off.
        let sizes: Vec<f64> = left.row_iter().map(|row| row.norm()).collect();
        let most = sizes.iter().fold(0.0_f64, |a, b| a.max(*b));
        let at = sizes.iter().position(|s| *s >= most * (1.0 - 1e-9));
        let at = at.unwrap_or(0);
        chosen.push(at);
        let direction = left.row(at).into_owned() / most.max(f64::MIN_POSITIVE);
        for mut row in left.row_iter_mut() {
            let along = row.dot(&direction);
            row -= &direction * along;
        }
    }
    chosen.sort_unstable();
    chosen
}

/// A basis of the balances that no column of the multipliers reaches, of a given number of columns.
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

/// Z and X. Rotations are taken times the length of the model while the basis is made orthonormal.
fn free_motions(
    system: &System,
    parameters: &Parameters,
    state: &State,
    lengths: &DVector<f64>,
) -> Result<(DMatrix<f64>, DMatrix<f64>), Reason> {
    let (n, equations) = (system.first_equation, system.equations);
    let mut scratch = Scratch::new(system);
    let mut g = vec![0.0; system.moving_unknowns];
    let mut rows = Rows::new(system);
    system.constraints_and_rows(parameters, state, &mut scratch, &mut g, &mut rows)?;
    let size = n.max(equations);
    let mut G = DMatrix::<f64>::zeros(size, n);
    for &(row, column, value) in &rows.entries {
        G[(row as usize, column as usize)] += value / lengths[column as usize];
    }
    if G.is_empty() {
        return Ok((DMatrix::zeros(n, 0), DMatrix::zeros(n, n)));
    }
    let svd = singular_values(G, true, true).ok_or(Reason::NoEigenvalues)?;
    let most = svd.singular_values.iter().fold(0.0_f64, |a, b| a.max(*b));
    let (U, Vt) = (svd.u.expect("asked for"), svd.v_t.expect("asked for"));
    let free: Vec<usize> = (0..n)
        .filter(|&k| svd.singular_values[k] <= NO_GRADIENT * most)
        .collect();
    let Z = DMatrix::from_fn(n, free.len(), |i, j| Vt[(free[j], i)] / lengths[i]);
    // H by differences of the rates along each freedom.
    let moves = state
        .velocities
        .iter()
        .any(|v| v.linear != Vec3::zeros() || v.angular != Vec3::zeros())
        || rows.time.iter().any(|t| *t != 0.0);
    if !moves {
        return Ok((Z, DMatrix::zeros(n, n)));
    }
    let mut v = Vec::new();
    system.velocity_vector(state, &mut v);
    let mut H = DMatrix::<f64>::zeros(equations, n);
    let mut step = vec![0.0; system.moving_unknowns];
    for column in 0..n {
        let h = STEP
            * if lengths[column] == 1.0 {
                system.length
            } else {
                1.0
            };
        for (weight, side) in [(8.0, 1.0), (-8.0, -1.0), (-1.0, 2.0), (1.0, -2.0)] {
            step[column] = side * h;
            let mut near = state.clone();
            system.advance(&mut near, &step);
            system.constraints_and_rows(parameters, &near, &mut scratch, &mut g, &mut rows)?;
            let mut rate = rows.time.clone();
            rows.times(&v, &mut rate);
            for (k, rate) in rate.iter().enumerate() {
                H[(k, column)] += weight * rate / (12.0 * h);
            }
        }
        step[column] = 0.0;
    }
    // X = -L^-1 (G L^-1)^+ H, L the lengths.
    let mut X = DMatrix::<f64>::zeros(n, n);
    for (k, value) in svd.singular_values.iter().enumerate() {
        if *value <= NO_GRADIENT * most {
            continue;
        }
        let along: RowDVector<f64> = U.column(k).rows(0, equations).transpose() * &H / *value;
        for i in 0..n {
            for j in 0..n {
                X[(i, j)] -= Vt[(k, i)] / lengths[i] * along[j];
            }
        }
    }
    Ok((Z, X))
}
