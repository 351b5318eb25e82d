//! Small motions about a state: eigenvalues and mode shapes.

use nalgebra::{Complex, DMatrix, DVector, RowDVector, SVD};

use super::error::Reason;
use crate::linear::Levels;
use crate::mechanics::eigen::eigenvalues;
use crate::mechanics::{Vec3, skew};
use crate::system::{Parameters, Rows, Scratch, State, System};

/// Singular values of the gradients below this share of the largest count as zero.
const NO_GRADIENT: f64 = 1e-9;
/// A mass matrix with a smaller pivot than this share of its largest entry is singular.
const NO_MASS: f64 = 1e-12;
/// Eigenvalues of the inverse problem below this share of the largest belong to motions without mass.
const INFINITE: f64 = 1e-11;
/// Steps of the differences of rates of constraints.
const STEP: f64 = 1e-5;

/// One eigenvalue and its motion.
#[derive(Clone, PartialEq, Debug)]
pub struct Mode {
    /// Per time: growth and angular frequency.
    pub value: Complex<f64>,
    /// Displacement and rotation vector of each part of the model, ground axes, scaled so that the largest component (rotations times the
    /// length of the model) is one. Ground does not move.
    pub shape: Vec<[Complex<f64>; 6]>,
}

impl Mode {
    /// Cycles per time of the undamped motion.
    pub fn frequency(&self) -> f64 {
        self.value.norm() / std::f64::consts::TAU
    }

    /// Damping ratio; one for motions that do not oscillate and die out, minus one for those that grow.
    pub fn damping_ratio(&self) -> f64 {
        let size = self.value.norm();
        if size > 0.0 {
            -self.value.re / size
        } else {
            0.0
        }
    }
}

/// The eigenvalues of the equations of motion linearised about a state, by frequency, those of a pair side by side.
///
/// `state` is at rest in equilibrium, or moves and satisfies the constraints at all three levels. With Z an orthonormal basis of the motions
/// that the gradients G leave free, H the derivative of the rates G V + Phi_t by the places and X = -G^+ H, small motions are d = Z y,
/// dV = Z x + X d, `y' = Z'(X + W) Z y + x`, W the angular velocities as matrices of cross products (`dphi' = dw + w x dphi`), and the
/// balance along Z gives x'. VARIABLEs follow, dynamic states are appended. Motions without mass have no finite eigenvalue and are left out.
/// `damped` false leaves the derivatives by velocities out.
///
/// # Errors
/// [`Reason`] where an element has no value.
pub fn modes(
    system: &System,
    parameters: &Parameters,
    state: &State,
    damped: bool,
) -> Result<Vec<Mode>, Reason> {
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
    let (Z, X) = free_motions(system, parameters, &state, &lengths)?;
    let r = Z.ncols();
    // Variables follow: dv = -J_vv^-1 (J_vq dq + J_vV dV + J_vs ds).
    let part = |level: usize, rows: (usize, usize), columns: (usize, usize)| {
        J[level]
            .view((rows.0, columns.0), (rows.1, columns.1))
            .into_owned()
    };
    let (B, V, S) = ((0, n), (variable, variables), (first_state, states));
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
    let Zt = Z.transpose();
    let size = 2 * r + states;
    let (mut E, mut F) = (DMatrix::identity(size, size), DMatrix::zeros(size, size));
    let put = |to: &mut DMatrix<f64>, row: usize, column: usize, block: &DMatrix<f64>| {
        to.view_mut((row, column), block.shape()).copy_from(block);
    };
    // The left inverse of Z, which is orthonormal where rotations are taken times the length.
    let left = DMatrix::from_fn(r, n, |i, j| Z[(j, i)] * lengths[j] * lengths[j]);
    put(&mut F, 0, 0, &(left * (&X + W) * &Z));
    put(&mut F, 0, r, &DMatrix::identity(r, r));
    put(&mut E, r, 0, &(&Zt * &M * &XZ));
    put(&mut E, r, r, &(&Zt * &M * &Z));
    put(&mut F, r, 0, &(&Zt * (&K * &Z + &C * &XZ)));
    put(&mut F, r, r, &(&Zt * &C * &Z));
    if states > 0 {
        put(&mut F, r, 2 * r, &(&Zt * reduced(0, B, S)));
        let (by_place, by_rate) = (reduced(0, S, B), reduced(1, S, B));
        put(&mut F, 2 * r, 0, &(&by_place * &Z + &by_rate * &XZ));
        put(&mut F, 2 * r, r, &(&by_rate * &Z));
        put(&mut F, 2 * r, 2 * r, &reduced(0, S, S));
        put(&mut E, 2 * r, 2 * r, &-part(1, S, S));
    }
    let values = finite_eigenvalues(&E, &F);
    let shapes = Shapes {
        system,
        Z: &Z,
        lengths: &lengths,
    };
    let mut found: Vec<Mode> = values
        .into_iter()
        .map(|value| Mode {
            shape: shapes.of(&E, &F, value),
            value,
        })
        .collect();
    // Sizes that differ by round-off are one: pairs stand side by side.
    let most = found
        .iter()
        .fold(0.0_f64, |a, mode| a.max(mode.value.norm()));
    let size = |mode: &Mode| (mode.value.norm() / most.max(f64::MIN_POSITIVE) * 1e9).round();
    found.sort_by(|a, b| {
        let by_size = size(a).total_cmp(&size(b));
        by_size
            .then(a.value.re.total_cmp(&b.value.re))
            .then(b.value.im.total_cmp(&a.value.im))
    });
    Ok(found)
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
    let Some(svd) = SVD::try_new(G, true, true, f64::EPSILON, 100 * size.max(1)) else {
        return Ok((DMatrix::zeros(n, 0), DMatrix::zeros(n, n)));
    };
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

/// The finite eigenvalues of `F u = value E u`.
fn finite_eigenvalues(E: &DMatrix<f64>, F: &DMatrix<f64>) -> Vec<Complex<f64>> {
    let lu = E.clone().full_piv_lu();
    let pivots = lu.u().diagonal();
    let most = pivots.amax();
    if pivots.iter().all(|p| p.abs() > NO_MASS * most)
        && let Some(matrix) = lu.solve(F)
    {
        return eigenvalues(matrix).unwrap_or_default();
    }
    // Without mass somewhere: the inverse problem about a shift, whose zeros are the infinite ones.
    let shift = 1.0 + F.amax() / E.amax().max(f64::MIN_POSITIVE) * 1e-3;
    let Some(inverse) = (F - E * shift).full_piv_lu().solve(E) else {
        return Vec::new();
    };
    let found = eigenvalues(inverse).unwrap_or_default();
    let most = found.iter().fold(0.0_f64, |a, b| a.max(b.norm()));
    found
        .into_iter()
        .filter(|mu| mu.norm() > INFINITE * most)
        .map(|mu| mu.inv() + shift)
        .collect()
}

/// From eigenvalues to motions of the parts.
struct Shapes<'a> {
    system: &'a System,
    Z: &'a DMatrix<f64>,
    lengths: &'a DVector<f64>,
}

impl Shapes<'_> {
    /// By inverse iteration next to the eigenvalue.
    fn of(
        &self,
        E: &DMatrix<f64>,
        F: &DMatrix<f64>,
        value: Complex<f64>,
    ) -> Vec<[Complex<f64>; 6]> {
        let size = E.nrows();
        let near = value * (1.0 + 1e-7) + 1e-10;
        let complex = |M: &DMatrix<f64>| M.map(|x| Complex::new(x, 0.0));
        let lu = (complex(F) - complex(E) * near).full_piv_lu();
        let mut u = DVector::from_fn(size, |k, _| Complex::new(1.0 + 0.37 * k as f64, 0.11));
        for _ in 0..3 {
            let Some(next) = lu.solve(&(complex(E) * &u)) else {
                break;
            };
            let norm = next.iter().fold(0.0_f64, |a, x| a.max(x.norm()));
            if !(norm > 0.0 && norm.is_finite()) {
                break;
            }
            u = next / Complex::new(norm, 0.0);
        }
        let r = self.Z.ncols();
        let d: DVector<Complex<f64>> = complex(self.Z) * u.rows(0, r);
        let largest = (0..d.len()).fold(Complex::new(0.0, 0.0), |best: Complex<f64>, k| {
            let x = d[k] * self.lengths[k];
            if x.norm() > best.norm() { x } else { best }
        });
        let scale = if largest.norm() > 0.0 {
            largest.inv()
        } else {
            Complex::new(0.0, 0.0)
        };
        self.system
            .bodies
            .iter()
            .map(|body| {
                std::array::from_fn(|k| {
                    if k < body.freedoms {
                        d[body.first + k] * scale
                    } else {
                        Complex::new(0.0, 0.0)
                    }
                })
            })
            .collect()
    }
}
