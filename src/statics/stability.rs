use nalgebra::{DMatrix, SymmetricEigen};

use super::SolveError;
use super::matrix::Matrix;
use crate::system::{Parameters, Scratch, State, System};

/// Freedoms above which eigenvalues are not worked out: the work grows with the third power.
const LARGE: usize = 600;

/// The smallest eigenvalue (real part) of the tangent stiffness over the motions the constraints allow, rotations taken times
/// the model's length: force per length. Negative where the equilibrium is unstable. `None` for large systems or if nothing can
/// move.
///
/// With Z a basis of the motions that no constraint resists, the eigenvalues of `Z' K Z`, K unsymmetric in general.
///
/// # Errors
/// [`SolveError::NoValue`] if an element has no value there.
pub fn smallest_eigenvalue(
    system: &System,
    parameters: &Parameters,
    state: &State,
) -> Result<Option<f64>, SolveError> {
    let n = system.first_equation;
    if n == 0 || n > LARGE {
        return Ok(None);
    }
    let mut matrix = Matrix::new(system.unknowns());
    let mut g = vec![0.0; system.unknowns()];
    let mut scratch = Scratch::new(system);
    system.assemble(parameters, state, &mut scratch, &mut g, &mut matrix)?;
    matrix.finish();
    let mut lengths = vec![1.0; n];
    for body in &system.bodies {
        for k in 3..body.freedoms.max(3) {
            lengths[body.first + k] = system.length;
        }
    }
    let mut K: DMatrix<f64> = DMatrix::zeros(n, n);
    let mut G: DMatrix<f64> = DMatrix::zeros(system.equations, n);
    for (row, column, value) in matrix.entries() {
        if column >= n {
            continue;
        }
        if row < n {
            K[(row, column)] -= value / (lengths[row] * lengths[column]);
        } else if row < system.first_variable {
            G[(row - n, column)] += value / lengths[column];
        }
    }
    // Every constraint counts alike, whatever its unit.
    for mut row in G.row_iter_mut() {
        let length = row.norm();
        if length > 0.0 {
            row /= length;
        }
    }
    let eigen = SymmetricEigen::new(G.transpose() * G);
    let free: Vec<usize> = (0..n).filter(|&k| eigen.eigenvalues[k] < 1e-12).collect();
    if free.is_empty() {
        return Ok(None);
    }
    let Z: DMatrix<f64> = eigen.eigenvectors.select_columns(&free);
    let reduced = Z.transpose() * K * Z;
    let smallest = reduced
        .complex_eigenvalues()
        .iter()
        .map(|e| e.re)
        .fold(f64::INFINITY, f64::min);
    Ok(Some(smallest))
}
