//! Small motions about a state: eigenvalues and mode shapes.

use nalgebra::{Complex, DMatrix, DVector};

use super::coordinates::Coordinates;
use super::error::MotionFailure;
use super::linearised::Linearised;
use crate::mechanics::Vec3;
use crate::mechanics::eigen::{eigenvalues, singular_values};
use crate::system::{Parameters, PartRates, State, System};

/// Singular values of the matrix E, which contains the coefficients of the rates, count as zero below this share of the largest.
const NO_MASS: f64 = 1e-12;

/// An eigenvalue and its mode shape.
#[derive(Clone, PartialEq, Debug)]
pub struct Mode {
    /// Eigenvalue, per unit of time. Its real part is the growth rate, its imaginary part the angular frequency.
    pub value: Complex<f64>,
    /// Displacement and rotation vector of each part, in ground axes; zero for ground. The shape is scaled so that its largest component is
    /// one, where rotations are multiplied by the model's length.
    pub shape: Vec<[Complex<f64>; 6]>,
}

impl Mode {
    /// Returns the undamped natural frequency in cycles per unit of time.
    pub fn frequency(&self) -> f64 {
        self.value.norm() / std::f64::consts::TAU
    }

    /// Returns the damping ratio: 1 for a motion that decays without oscillation, -1 for a motion that grows without oscillation.
    pub fn damping_ratio(&self) -> f64 {
        let size = self.value.norm();
        if size > 0.0 {
            -self.value.re / size
        } else {
            0.0
        }
    }
}

/// Computes the modes of the equations of motion linearised about a state, sorted by frequency, with complex pairs side by side.
///
/// `state` is at rest in equilibrium, or it moves and satisfies the constraints at all three levels. Motions without mass have no finite
/// eigenvalue and are omitted. If `damped` is false, the derivatives of forces with respect to velocities are omitted.
///
/// # Errors
/// Returns [`MotionFailure`] if an element has no value or the eigenvalue iteration does not converge.
pub fn modes(
    system: &System,
    parameters: &Parameters,
    state: &State,
    damped: bool,
) -> Result<Vec<Mode>, MotionFailure> {
    modes_in(system, parameters, state, damped, &Coordinates::default())
}

/// Computes the modes of the equations of motion in the given coordinates. The choice of coordinates matters only for a moving state. The
/// linearised equations of such a state change with time in some coordinates and not in others, and only their present values are used.
///
/// # Errors
/// Returns the errors of [`modes`].
pub fn modes_in(
    system: &System,
    parameters: &Parameters,
    state: &State,
    damped: bool,
    coordinates: &Coordinates,
) -> Result<Vec<Mode>, MotionFailure> {
    // For a state at rest, all coordinates give the same eigenvalues.
    let still = |v: &PartRates| v.linear == Vec3::zeros() && v.angular == Vec3::zeros();
    let moves = !state.velocities.iter().all(still);
    let coordinates = moves.then_some(coordinates);
    let about = Linearised::new(system, parameters, state, damped, coordinates)?;
    let (E, F) = (&about.E, &about.F);
    let shapes = Shapes {
        system,
        Z: &about.Z,
        lengths: &about.lengths,
    };
    let mut found: Vec<Mode> = finite_eigenvalues(E, F)
        .ok_or(MotionFailure::NoEigenvalues)?
        .into_iter()
        .map(|value| Mode {
            shape: shapes.of(E, F, value),
            value,
        })
        .collect();
    // Magnitudes that differ by round-off count as equal, so that complex pairs stay side by side.
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

/// Computes the finite eigenvalues of `F u = value E u`. Returns `None` if an iteration does not converge.
///
/// Combinations of rows in which E vanishes are algebraic: `A u = 0`. They are eliminated by writing u in a basis of their null space,
/// `u = N y`, repeatedly if necessary. A motion without inertia that only stiffness restrains takes two rounds: the first removes its position,
/// and the second its velocity.
fn finite_eigenvalues(E: &DMatrix<f64>, F: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    let (mut E, mut F) = (E.clone(), F.clone());
    while E.nrows() > 0 {
        let found = singular_values(E.clone(), true, false)?;
        let most = found.singular_values.amax();
        let (with_rate, without): (Vec<usize>, Vec<usize>) =
            (0..E.nrows()).partition(|k| found.singular_values[*k] > NO_MASS * most);
        if without.is_empty() {
            return eigenvalues(E.full_piv_lu().solve(&F)?);
        }
        let U = found.u?;
        let algebraic = U.select_columns(&without).tr_mul(&F);
        let rows = U.select_columns(&with_rate);
        let free = null_space(&algebraic, without.len())?;
        (E, F) = (rows.tr_mul(&E) * &free, rows.tr_mul(&F) * &free);
    }
    Some(Vec::new())
}

/// Returns an orthonormal basis of the null space of `rows`, which has `count` independent rows of length n. The basis has n - `count` columns.
fn null_space(rows: &DMatrix<f64>, count: usize) -> Option<DMatrix<f64>> {
    let n = rows.ncols();
    // Additional rows of zeros make the right singular vectors a complete basis.
    let whole = rows.clone().resize_vertically(n, 0.0);
    let Vt = singular_values(whole, false, true)?.v_t?;
    Some(Vt.rows(count, n - count).transpose())
}

/// Data with which mode shapes are computed from eigenvalues.
struct Shapes<'a> {
    system: &'a System,
    Z: &'a DMatrix<f64>,
    lengths: &'a DVector<f64>,
}

impl Shapes<'_> {
    /// Computes a mode shape by inverse iteration next to its eigenvalue.
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
