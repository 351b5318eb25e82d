//! Bases of the free motions of a state under its constraints, and the change of these bases as the state moves.

use nalgebra::{DMatrix, DVector, RowDVector};

use super::coordinates::Coordinates;
use super::error::MotionFailure;
use crate::mechanics::eigen::singular_values;
use crate::mechanics::{Vec3, skew};
use crate::system::{Parameters, Rows, Scratch, State, System};

/// Singular values of the constraint gradients below this share of the largest count as zero.
const NO_GRADIENT: f64 = 1e-9;
/// Step of the fourth-order finite differences of constraint rates, in model lengths for translations and in radians for rotations.
const STEP: f64 = 1e-3;
/// Time step of the finite differences along the motion, as a share of the time in which parts move by a model length or rotate by a radian.
const ALONG: f64 = 1e-4;

/// Small motions of the parts in terms of coordinates y and their rates v: `d = Z y`, `dV = V v + U y`, `y' = of_places y + of_rates v`. Z,
/// V and U have one row per unknown of the parts.
///
/// Z is a basis of the motions that the constraint gradients leave free for positions, and V is the basis for velocities. Z and V are equal
/// unless nonholonomic constraints leave fewer free velocities. U is the change of velocities with positions at fixed v; it is nonzero only
/// for a moving state.
#[derive(Clone, Debug)]
pub(super) struct FreedomBases {
    pub Z: DMatrix<f64>,
    pub V: DMatrix<f64>,
    pub U: DMatrix<f64>,
    pub of_places: DMatrix<f64>,
    pub of_rates: DMatrix<f64>,
    /// Time derivative of V, for `dA = V v' + U y' + V' v + U' y`. It has the shape of V.
    pub V_rate: DMatrix<f64>,
    /// Time derivative of U, with the shape of U.
    pub U_rate: DMatrix<f64>,
    /// Indices of the candidate coordinates that y consists of; empty for an orthonormal basis.
    pub chosen: Vec<usize>,
    /// Indices of the candidate coordinates whose rates v consists of; empty for an orthonormal basis.
    pub chosen_rates: Vec<usize>,
}

impl FreedomBases {
    /// Computes the bases for the given coordinates. If `coordinates` is `None`, the bases are orthonormal when rotations are multiplied by the
    /// model's length. `None` is allowed only for a state at rest.
    ///
    /// Y is the derivative of the coordinates with respect to the motions of the parts. Z and V are scaled so that `Y Z = 1` and `Y V = 1`. H
    /// is the derivative of the constraint rates G V + Phi_t with respect to the positions, and X = -G^+ H. W contains the angular velocities
    /// as cross-product matrices, from `dphi' = dw + w x dphi`. Then `y' = Y (dV + W d) + Y' d`, which gives `U = X Z - V S`. S consists of the
    /// rows of `(Y X + Y W + Y') Z` that belong to the rates v.
    ///
    /// # Errors
    /// Returns [`MotionFailure`] if an element has no value.
    pub(super) fn of(
        system: &System,
        parameters: &Parameters,
        state: &State,
        coordinates: Option<&Coordinates>,
        lengths: &DVector<f64>,
    ) -> Result<Self, MotionFailure> {
        let whole = (system, parameters, state);
        let bare = FreeBases::of(whole, lengths)?;
        let n = lengths.len();
        let (p, r) = (bare.Z.ncols(), bare.velocities().ncols());
        let Some(coordinates) = coordinates else {
            // Left inverse of Z, which is orthonormal when rotations are multiplied by the model's length.
            let left = DMatrix::from_fn(p, n, |i, j| bare.Z[(j, i)] * lengths[j] * lengths[j]);
            let V = bare.velocities().clone();
            return Ok(Self {
                of_rates: if bare.R.is_some() {
                    left * &V
                } else {
                    DMatrix::identity(p, r)
                },
                U: DMatrix::zeros(n, p),
                of_places: DMatrix::zeros(p, p),
                V_rate: DMatrix::zeros(n, r),
                U_rate: DMatrix::zeros(n, p),
                chosen: Vec::new(),
                chosen_rates: Vec::new(),
                Z: bare.Z,
                V,
            });
        };
        let Y = coordinates.rows(system, parameters, state)?;
        let chosen = coordinates.chosen(system, &Y, &bare.Z, lengths);
        let chosen_rates = match &bare.R {
            Some(R) => coordinates.chosen(system, &Y, R, lengths),
            None => chosen.clone(),
        };
        let moves = bare.moves;
        let seen = CoordinatePartition {
            coordinates,
            chosen: &chosen,
            chosen_rates: &chosen_rates,
            lengths,
        };
        if !moves {
            return Ok(seen.from(bare, &Y, &DMatrix::zeros(Y.nrows(), n), whole));
        }
        let h = ALONG / pace(system, state);
        let near: Vec<State> = [-2.0, -1.0, 1.0, 2.0]
            .map(|k| along(system, state, k * h))
            .into();
        let slope = |before: &DMatrix<f64>, after: &DMatrix<f64>| (after - before) / (2.0 * h);
        let rows_of = |state: &State| coordinates.rows(system, parameters, state);
        let Ys = [
            rows_of(&near[0])?,
            rows_of(&near[1])?,
            Y,
            rows_of(&near[2])?,
            rows_of(&near[3])?,
        ];
        let at = |k: usize, state: &State, bare: FreeBases| {
            let here = (system, parameters, state);
            seen.from(bare, &Ys[k], &slope(&Ys[k - 1], &Ys[k + 1]), here)
        };
        let side = |k: usize, state: &State| {
            FreeBases::of((system, parameters, state), lengths).map(|bare| at(k, state, bare))
        };
        let (before, after) = (side(1, &near[1])?, side(3, &near[2])?);
        let mut here = at(2, state, bare);
        if before.V.shape() == here.V.shape() && after.V.shape() == here.V.shape() {
            here.V_rate = slope(&before.V, &after.V);
            here.U_rate = slope(&before.U, &after.U);
        }
        Ok(here)
    }
}

/// The coordinates, and the rates of coordinates, that were chosen from the candidates.
struct CoordinatePartition<'a> {
    coordinates: &'a Coordinates,
    chosen: &'a [usize],
    chosen_rates: &'a [usize],
    lengths: &'a DVector<f64>,
}

impl CoordinatePartition<'_> {
    /// Converts arbitrary bases to the bases of the chosen coordinates.
    fn from(
        &self,
        bare: FreeBases,
        Y: &DMatrix<f64>,
        Y_rate: &DMatrix<f64>,
        (system, _, state): (&System, &Parameters, &State),
    ) -> FreedomBases {
        let n = self.lengths.len();
        let of = |rows: &[usize], of: &DMatrix<f64>| of.select_rows(rows);
        let scaled = |mut basis: DMatrix<f64>, rows: &[usize]| {
            if let Some(inverse) = (of(rows, Y) * &basis).try_inverse() {
                basis *= inverse;
            }
            basis
        };
        let holonomic = bare.R.is_none();
        let V = scaled(bare.R.unwrap_or_else(|| bare.Z.clone()), self.chosen_rates);
        let Z = scaled(bare.Z, self.chosen);
        let (p, r) = (Z.ncols(), V.ncols());
        let mut W = DMatrix::zeros(n, n);
        for (body, velocity) in system.bodies.iter().zip(&state.velocities) {
            if body.freedoms == 6 {
                let at = body.first + 3;
                W.view_mut((at, at), (3, 3))
                    .copy_from(&skew(&velocity.angular));
            }
        }
        let turned = if self.coordinates.are_plain() {
            Y * W
        } else {
            Y * W + Y_rate
        };
        // Rates of all candidate coordinates per unit of y, caused by the velocity change X Z y.
        let convected = (Y * &bare.X + turned) * &Z;
        let S = of(self.chosen_rates, &convected);
        let U = &bare.X * &Z - &V * &S;
        let (of_places, of_rates) = if holonomic {
            (DMatrix::zeros(p, p), DMatrix::identity(p, r))
        } else {
            let of_rates = of(self.chosen, Y) * &V;
            (of(self.chosen, &convected) - &of_rates * &S, of_rates)
        };
        FreedomBases {
            V_rate: DMatrix::zeros(n, r),
            U_rate: DMatrix::zeros(n, p),
            Z,
            V,
            U,
            of_places,
            of_rates,
            chosen: self.chosen.to_vec(),
            chosen_rates: self.chosen_rates.to_vec(),
        }
    }
}

/// Returns the larger of the largest angular velocity and the largest velocity divided by the model's length. Returns one if no part moves.
fn pace(system: &System, state: &State) -> f64 {
    let pace = state.velocities.iter().fold(0.0_f64, |most, v| {
        most.max(v.angular.norm())
            .max(v.linear.norm() / system.length)
    });
    if pace > 0.0 { pace } else { 1.0 }
}

/// Returns the state after a short time `h`, extrapolated to second order.
fn along(system: &System, state: &State, h: f64) -> State {
    let (mut v, mut a) = (Vec::new(), Vec::new());
    system.velocity_vector(state, &mut v);
    system.gathered(&state.accelerations, &mut a);
    let mut step = vec![0.0; system.moving_unknowns];
    for ((step, v), a) in step.iter_mut().zip(&v).zip(&a) {
        *step = h * v + 0.5 * h * h * a;
    }
    let mut next = state.clone();
    system.advance(&mut next, &step);
    next.time += h;
    for (rates, more) in next.velocities.iter_mut().zip(&state.accelerations) {
        rates.linear += more.linear * h;
        rates.angular += more.angular * h;
    }
    next
}

/// Arbitrary bases of the free motions.
struct FreeBases {
    /// Basis of the free motions of the positions, one motion per column.
    Z: DMatrix<f64>,
    /// Basis of the free motions of the velocities, one motion per column. `None` if this basis equals Z, because no nonholonomic constraint acts.
    R: Option<DMatrix<f64>>,
    X: DMatrix<f64>,
    moves: bool,
}

impl FreeBases {
    fn velocities(&self) -> &DMatrix<f64> {
        self.R.as_ref().unwrap_or(&self.Z)
    }

    /// Computes the bases. They are orthonormal when rotations are multiplied by the model's length.
    fn of(
        (system, parameters, state): (&System, &Parameters, &State),
        lengths: &DVector<f64>,
    ) -> Result<Self, MotionFailure> {
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
        if n == 0 {
            return Ok(Self {
                Z: DMatrix::zeros(n, 0),
                R: None,
                X: DMatrix::zeros(n, n),
                moves: false,
            });
        }
        let svd = singular_values(G, true, true).ok_or(MotionFailure::NoEigenvalues)?;
        let most = svd.singular_values.iter().fold(0.0_f64, |a, b| a.max(*b));
        let (U, Vt) = (svd.u.expect("asked for"), svd.v_t.expect("asked for"));
        let free = left_free(&svd.singular_values, &Vt, lengths);
        let of_velocities = |&k: &usize| system.is_nonholonomic[k] && system.is_effective(state, k);
        let (Z, R) = if (0..equations).any(|k| of_velocities(&k)) {
            let G = gradients(&|k| !system.is_nonholonomic[k]);
            let svd = singular_values(G, false, true).ok_or(MotionFailure::NoEigenvalues)?;
            let Vt = svd.v_t.expect("asked for");
            (left_free(&svd.singular_values, &Vt, lengths), Some(free))
        } else {
            (free, None)
        };
        // H by finite differences of the constraint rates along each unknown.
        let moves = state
            .velocities
            .iter()
            .any(|v| v.linear != Vec3::zeros() || v.angular != Vec3::zeros())
            || rows.time.iter().any(|t| *t != 0.0);
        if !moves {
            let X = DMatrix::zeros(n, n);
            return Ok(Self { Z, R, X, moves });
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
        // X = -L^-1 (G L^-1)^+ H, where L is the diagonal matrix of the lengths.
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
        Ok(Self { Z, R, X, moves })
    }
}

/// Returns a basis of the null space of the constraint gradients, from their singular value decomposition.
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
