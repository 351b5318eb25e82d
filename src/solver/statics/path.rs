//! Additions to the Jacobian that change the path to the equilibrium, but not the equilibrium.

use crate::linear::Matrix;
use crate::model::PartIx;
use crate::system::{Parameters, State, System};

/// Adds the mass matrix of every part to the stiffness block, times STABILITY and divided by the units consistency factor.
pub(super) fn add_stability(
    system: &System,
    parameters: &Parameters,
    state: &State,
    stability: f64,
    matrix: &mut Matrix,
) {
    for (part, body) in system.bodies.iter().enumerate() {
        let M = system.mass_matrix(parameters, state, PartIx(part));
        for i in 0..body.freedoms {
            for j in 0..body.freedoms {
                matrix.add_later(body.first + i, body.first + j, -stability * M[(i, j)]);
            }
        }
    }
}

/// Adds viscous damping to the stiffness block of every part. The damping of rotations is multiplied by the square of the model's length.
pub(super) fn add_damping(system: &System, damping: f64, matrix: &mut Matrix) {
    for body in &system.bodies {
        for k in 0..body.freedoms {
            let scale = if k < 3 {
                1.0
            } else {
                system.length * system.length
            };
            matrix.add_later(body.first + k, body.first + k, -damping * scale);
        }
    }
}
