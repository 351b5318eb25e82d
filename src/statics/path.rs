//! What is added to the Jacobian to change the way to the equilibrium, and never the equilibrium.

use super::matrix::Matrix;
use crate::mechanics::{Mat6, Vec3, skew};
use crate::system::{Parameters, State, System};

/// STABILITY times mass, over the units consistency factor, to the stiffness block.
pub(super) fn add_stability(
    system: &System,
    parameters: &Parameters,
    state: &State,
    stability: f64,
    matrix: &mut Matrix,
) {
    for (body, pose) in system.bodies.iter().zip(&state.poses) {
        if body.freedoms == 0 {
            continue;
        }
        let mass = parameters.theta()[body.mass];
        let arm = body
            .cm
            .map_or_else(Vec3::zeros, |cm| pose.R * parameters.markers()[cm].p);
        let r = skew(&arm) * mass;
        let mut M = Mat6::zeros();
        for k in 0..3 {
            M[(k, k)] = mass;
        }
        let inertia = pose.R * body.inertia * pose.R.transpose() - r * skew(&arm);
        M.fixed_view_mut::<3, 3>(0, 3).copy_from(&-r);
        M.fixed_view_mut::<3, 3>(3, 0).copy_from(&r);
        M.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
        for i in 0..body.freedoms {
            for j in 0..body.freedoms {
                let value = -stability / system.ucf * M[(i, j)];
                matrix.add_later(body.first + i, body.first + j, value);
            }
        }
    }
}

/// As if every part moved in honey.
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
