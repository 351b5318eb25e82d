//! Sizes of residuals and corrections, as compared with the tolerances of the EQUILIBRIUM statement.

use super::{Far, StaticSettings};
use crate::mechanics::{larger, log};
use crate::model::PartIx;
use crate::system::{State, System};

/// Returns the magnitude of the largest entry.
pub(super) fn largest(g: &[f64]) -> f64 {
    g.iter().fold(0.0, |most, value| larger(most, value.abs()))
}

/// Returns the magnitude of the largest unbalanced force or torque component. Torques are divided by the model's length.
pub(super) fn force_imbalance(system: &System, g: &[f64]) -> f64 {
    let mut out = 0.0_f64;
    for body in &system.bodies {
        for k in 0..body.freedoms {
            let scale = if k < 3 { 1.0 } else { system.length };
            out = larger(out, g[body.first + k].abs() / scale);
        }
    }
    out
}

/// Returns true if every residual is within IMBALANCE, or within the round-off of the terms that cancel in it. `force` is the largest force
/// that cancels in the balances.
pub(super) fn balanced(system: &System, g: &[f64], imbalance: f64, force: f64) -> bool {
    let floor = 64.0 * f64::EPSILON * force;
    for body in &system.bodies {
        for k in 0..body.freedoms {
            let scale = if k < 3 { 1.0 } else { 4.0 * system.length };
            // The comparison is written so that a NaN counts as unbalanced.
            let within = g[body.first + k].abs() <= imbalance.max(floor * scale);
            if !within {
                return false;
            }
        }
    }
    let floor = 64.0 * f64::EPSILON * system.length;
    g[system.first_equation..]
        .iter()
        .all(|g| g.abs() <= imbalance.max(floor))
}

/// Returns the largest relative correction of any unknown. Translations are relative to the position or the model's length, whichever is
/// larger; rotations are in radians. Multipliers are relative to the largest multiplier, but at least to one. Variables and states are relative
/// to their own value, but at least to one.
pub(super) fn relative_correction(system: &System, state: &State, dx: &[f64]) -> f64 {
    let mut out = 0.0_f64;
    for (part, body) in system.bodies.iter().enumerate() {
        let d = &dx[body.first..body.first + body.freedoms];
        let place = system.reference_point(state, PartIx(part));
        for k in 0..body.freedoms {
            let scale = if k < 3 {
                place[k].abs().max(system.length)
            } else {
                1.0
            };
            out = larger(out, d[k].abs() / scale);
        }
    }
    let largest = state
        .multipliers
        .iter()
        .fold(1.0_f64, |a, b| a.max(b.abs()));
    for d in &dx[system.first_equation..system.first_variable] {
        out = larger(out, d.abs() / largest);
    }
    for (k, unknown) in system.implicit_variables() {
        out = larger(out, dx[unknown].abs() / state.variables[k].abs().max(1.0));
    }
    for (equation, value) in system.states.iter().zip(&state.states) {
        if let Some(unknown) = equation.unknown {
            out = larger(out, dx[unknown].abs() / value.abs().max(1.0));
        }
    }
    out
}

/// Returns the largest fraction of a Newton step, at most one, that keeps every part within TLIMIT and ALIMIT.
pub(super) fn limit(system: &System, settings: &StaticSettings, dx: &[f64]) -> f64 {
    let (mut shift, mut turn) = (0.0_f64, 0.0_f64);
    for body in &system.bodies {
        for k in 0..body.freedoms {
            let d = dx[body.first + k].abs();
            if k < 3 {
                shift = shift.max(d);
            } else {
                turn = turn.max(d);
            }
        }
    }
    let mut out = 1.0;
    if shift > settings.tlimit {
        out = settings.tlimit / shift;
    }
    if turn * out > settings.alimit {
        out = settings.alimit / turn;
    }
    out
}

/// Returns the distance that the reference point of a part moved between two states, and the angle in radians by which the part rotated.
pub(super) fn moved(system: &System, a: &State, b: &State, part: PartIx) -> (f64, f64) {
    let shift = system.reference_point(b, part) - system.reference_point(a, part);
    let turn = log(&(a.poses[part.0].R.transpose() * b.poses[part.0].R));
    (shift.norm(), turn.norm())
}

/// Returns the parts that turned or moved far between two states: by more than [`Far::TURN`] or by more than the size of the mechanism.
pub(super) fn far(system: &System, a: &State, b: &State) -> Vec<Far> {
    let parts = (0..system.bodies.len()).map(PartIx);
    let gone = parts.filter_map(|part| {
        let (shift, turn) = moved(system, a, b, part);
        let far = turn > Far::TURN || shift > system.extent;
        far.then(|| Far {
            part: system.part_name(part).clone(),
            shift,
            turn,
        })
    });
    gone.collect()
}

/// Returns the largest motion of any part between two states. Rotations are multiplied by the model's length.
pub(super) fn distance(system: &System, a: &State, b: &State) -> f64 {
    let apart = (0..system.bodies.len()).map(|part| {
        let (shift, turn) = moved(system, a, b, PartIx(part));
        shift.max(turn * system.length)
    });
    apart.fold(0.0, f64::max)
}

/// Returns the Euclidean norm of the motion of all parts. Rotations are multiplied by the model's length.
pub(super) fn motion_norm(system: &System, dx: &[f64]) -> f64 {
    let mut sum = 0.0;
    for body in &system.bodies {
        for k in 0..body.freedoms {
            let scale = if k < 3 { 1.0 } else { system.length };
            sum += (dx[body.first + k] * scale).powi(2);
        }
    }
    sum.sqrt()
}
