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
/// Constraints of velocities are rows of G beside dV alone: they leave fewer velocities free than places, x has a basis R of its own.
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
    /// How many numbers x has.
    pub rates: usize,
    /// One for translations, the length of the model for rotations.
    pub lengths: DVector<f64>,
    /// The unknowns of the parts that y is, in a basis of coordinates.
    pub chosen: Vec<usize>,
    /// The unknowns of the parts whose rates x is, in a basis of coordinates.
    pub chosen_rates: Vec<usize>,
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
        let Free { mut Z, R, X } = Free::of(system, parameters, &state, &lengths)?;
        let mut chosen = Vec::new();
        if basis == Basis::Coordinates {
            chosen = in_coordinates(&mut Z, &lengths);
        }
        let mut chosen_rates = chosen.clone();
        let R = R.map(|mut R| {
            if basis == Basis::Coordinates {
                chosen_rates = in_coordinates(&mut R, &lengths);
            }
            R
        });
        // y are as many as places, x as velocities are free.
        let (p, r) = (Z.ncols(), R.as_ref().unwrap_or(&Z).ncols());
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
            unreached(&by_multipliers, r, &lengths)
        } else {
            None
        };
        let free = R.as_ref().unwrap_or(&Z);
        let Nt = N.as_ref().unwrap_or(free).transpose();
        let size = p + r + states;
        let (mut E, mut F) = (DMatrix::identity(size, size), DMatrix::zeros(size, size));
        let mut input = DMatrix::zeros(size, variables);
        let put = |to: &mut DMatrix<f64>, row: usize, column: usize, block: &DMatrix<f64>| {
            to.view_mut((row, column), block.shape()).copy_from(block);
        };
        let left = match basis {
            // The left inverse of Z, which is orthonormal where rotations are taken times the length.
            Basis::Orthonormal => {
                DMatrix::from_fn(p, n, |i, j| Z[(j, i)] * lengths[j] * lengths[j])
            }
            Basis::Coordinates => {
                DMatrix::from_fn(p, n, |i, j| f64::from(u8::from(chosen[i] == j)))
            }
        };
        let of_rates = match &R {
            Some(R) => &left * R,
            None => DMatrix::identity(p, r),
        };
        put(&mut F, 0, 0, &(left * (&X + W) * &Z));
        put(&mut F, 0, p, &of_rates);
        put(&mut E, p, 0, &(&Nt * &M * &XZ));
        put(&mut E, p, p, &(&Nt * &M * free));
        put(&mut F, p, 0, &(&Nt * (&K * &Z + &C * &XZ)));
        put(&mut F, p, p, &(&Nt * &C * free));
        put(&mut input, p, 0, &(&Nt * part(0, B, V) * &follow));
        let s = p + r;
        if states > 0 {
            put(&mut F, p, s, &(&Nt * reduced(0, B, S)));
            let (by_place, by_rate) = (reduced(0, S, B), reduced(1, S, B));
            put(&mut F, s, 0, &(&by_place * &Z + &by_rate * &XZ));
            put(&mut F, s, p, &(&by_rate * free));
            put(&mut F, s, s, &reduced(0, S, S));
            put(&mut E, s, s, &-part(1, S, S));
            put(&mut input, s, 0, &(part(0, S, V) * &follow));
        }
        // dv = follow (dw - J_v by places, velocities, accelerations, states and their rates).
        let mut by_u = DMatrix::zeros(variables, size);
        let mut by_rate = DMatrix::zeros(variables, size);
        let along = |level: usize| -(&follow * part(level, V, B));
        put(&mut by_u, 0, 0, &(along(0) * &Z + along(1) * &XZ));
        put(&mut by_u, 0, p, &(along(1) * free));
        put(&mut by_rate, 0, 0, &(along(2) * &XZ));
        put(&mut by_rate, 0, p, &(along(2) * free));
        if states > 0 {
            put(&mut by_u, 0, s, &-(&follow * part(0, V, S)));
            put(&mut by_rate, 0, s, &-(&follow * part(1, V, S)));
        }
        Ok(Self {
            E,
            F,
            B: input,
            by_u,
            by_rate,
            by_input: follow,
            rates: r,
            Z,
            lengths,
            chosen,
            chosen_rates,
        })
    }
}

/// Makes the columns those of which each moves one of some coordinates; gives these.
fn in_coordinates(Z: &mut DMatrix<f64>, lengths: &DVector<f64>) -> Vec<usize> {
    let r = Z.ncols();
    if r == 0 {
        return Vec::new();
    }
    let chosen = coordinates(Z, lengths);
    let square = DMatrix::from_fn(r, r, |i, j| Z[(chosen[i], j)]);
    if let Some(inverse) = square.try_inverse() {
        *Z *= inverse;
    }
    chosen
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

/// What the constraints leave free.
struct Free {
    /// Motions by the places.
    Z: DMatrix<f64>,
    /// Motions by the velocities, where constraints of velocities leave fewer of them.
    R: Option<DMatrix<f64>>,
    X: DMatrix<f64>,
}

impl Free {
    /// Rotations are taken times the length of the model while the bases are made orthonormal.
    fn of(
        system: &System,
        parameters: &Parameters,
        state: &State,
        lengths: &DVector<f64>,
    ) -> Result<Self, Reason> {
        let (n, equations) = (system.first_equation, system.equations);
        let mut scratch = Scratch::new(system);
        let mut g = vec![0.0; system.moving_unknowns];
        let mut rows = Rows::new(system);
        system.constraints_and_rows(parameters, state, &mut scratch, &mut g, &mut rows)?;
        let gradients = |counts: &dyn Fn(usize) -> bool| {
            let mut G = DMatrix::<f64>::zeros(n.max(equations), n);
            for &(row, column, value) in &rows.entries {
                if counts(row as usize) {
                    G[(row as usize, column as usize)] += value / lengths[column as usize];
                }
            }
            G
        };
        let G = gradients(&|_| true);
        if G.is_empty() {
            return Ok(Self {
                Z: DMatrix::zeros(n, 0),
                R: None,
                X: DMatrix::zeros(n, n),
            });
        }
        let svd = singular_values(G, true, true).ok_or(Reason::NoEigenvalues)?;
        let most = svd.singular_values.iter().fold(0.0_f64, |a, b| a.max(*b));
        let (U, Vt) = (svd.u.expect("asked for"), svd.v_t.expect("asked for"));
        let free = left_free(&svd.singular_values, &Vt, lengths);
        let of_velocities = |&k: &usize| system.of_velocities[k] && system.takes_part(state, k);
        let (Z, R) = if (0..equations).any(|k| of_velocities(&k)) {
            let G = gradients(&|k| !system.of_velocities[k]);
            let svd = singular_values(G, false, true).ok_or(Reason::NoEigenvalues)?;
            let Vt = svd.v_t.expect("asked for");
            (left_free(&svd.singular_values, &Vt, lengths), Some(free))
        } else {
            (free, None)
        };
        // H by differences of the rates along each freedom.
        let moves = state
            .velocities
            .iter()
            .any(|v| v.linear != Vec3::zeros() || v.angular != Vec3::zeros())
            || rows.time.iter().any(|t| *t != 0.0);
        if !moves {
            let X = DMatrix::zeros(n, n);
            return Ok(Self { Z, R, X });
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
        Ok(Self { Z, R, X })
    }
}

/// A basis of the motions along which no gradient has a value, from the singular values of the gradients.
fn left_free(
    singular_values: &DVector<f64>,
    Vt: &DMatrix<f64>,
    lengths: &DVector<f64>,
) -> DMatrix<f64> {
    let n = lengths.len();
    let most = singular_values.iter().fold(0.0_f64, |a, b| a.max(*b));
    let free: Vec<usize> = (0..n)
        .filter(|&k| singular_values[k] <= NO_GRADIENT * most)
        .collect();
    DMatrix::from_fn(n, free.len(), |i, j| Vt[(free[j], i)] / lengths[i])
}
