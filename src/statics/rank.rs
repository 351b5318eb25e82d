//! Motions nothing resists and constraint equations that say nothing new, in the user's words.

use super::matrix::Matrix;
use super::report::FreeMotion;
use crate::mechanics::Vec3;
use crate::model::PartIx;
use crate::system::{Parameters, State, System};

/// A constraint row that keeps less than this of its length when its share in the rows before is taken off is redundant.
const REDUNDANT: f64 = 1e-8;

/// Beyond so many products the factorisation alone finds redundant equations.
const LARGE: usize = 1_000_000_000;

/// Which constraint equations depend on those before them. `J` holds the whole Jacobian, not factored.
pub(super) fn redundant_equations(system: &System, J: &Matrix) -> Vec<bool> {
    let columns = system.first_equation;
    if system.equations.pow(2).saturating_mul(columns) > LARGE {
        return vec![false; system.equations];
    }
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let scale = column_lengths(system);
    let mut out = vec![false; system.equations];
    let mut rows = vec![Vec::new(); system.equations];
    for (row, column, value) in J.entries() {
        let equation = system.first_equation..system.first_variable;
        if column < columns && equation.contains(&row) {
            rows[row - system.first_equation].push((column, value / scale[column]));
        }
    }
    for (row, redundant) in rows.iter().zip(&mut out) {
        let mut v = vec![0.0; columns];
        for &(column, value) in row {
            v[column] = value;
        }
        let before = norm(&v);
        // An equation without any gradient cannot be held by anything: it is another's business.
        if before == 0.0 {
            *redundant = true;
            continue;
        }
        // Twice is enough (Kahan).
        for _ in 0..2 {
            for b in &basis {
                let share: f64 = v.iter().zip(b).map(|(x, y)| x * y).sum();
                for (x, y) in v.iter_mut().zip(b) {
                    *x -= share * y;
                }
            }
        }
        let after = norm(&v);
        if after < REDUNDANT * before {
            *redundant = true;
        } else {
            for x in &mut v {
                *x /= after;
            }
            basis.push(v);
        }
    }
    out
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// What one unit of each body unknown moves: 1 for translations, the length of the model for rotations.
fn column_lengths(system: &System) -> Vec<f64> {
    let mut out = vec![1.0; system.first_equation];
    for body in &system.bodies {
        for k in 3..body.freedoms.max(3) {
            out[body.first + k] = system.length;
        }
    }
    out
}

/// Says a free motion in words. `None` if no part moves in it (then multipliers or variables are undetermined).
pub(super) fn free_motion(
    system: &System,
    parameters: &Parameters,
    state: &State,
    z: &[f64],
) -> Option<FreeMotion> {
    let mut largest: Option<(usize, f64)> = None;
    let mut sizes = Vec::new();
    for (part, body) in system.bodies.iter().enumerate() {
        let (v, w) = motion_of(system, part, z);
        let size = v.norm().max(w.norm() * system.length);
        sizes.push(size);
        if body.freedoms > 0 && size > largest.map_or(0.0, |l| l.1) {
            largest = Some((part, size));
        }
    }
    let (part, size) = largest?;
    // Multipliers scale as forces; a motion far below their noise is none.
    let multipliers = z[system.first_equation..]
        .iter()
        .fold(0.0_f64, |a, b| a.max(b.abs()));
    if size < 1e-12 * multipliers {
        return None;
    }
    let (v, w) = motion_of(system, part, z);
    let turns = w.norm() * system.length > 1e-6 * size;
    let axis = if turns { w.normalize() } else { v.normalize() };
    let motion = if turns {
        spin(system, parameters, state, part, &v, &w)
    } else {
        format!("is held by nothing along {}", direction(&axis))
    };
    let others = (0..system.bodies.len())
        .filter(|&other| other != part && sizes[other] > 1e-6 * size)
        .map(|other| system.part_name(PartIx(other)).clone())
        .collect();
    let moving: Vec<usize> = (0..system.bodies.len())
        .filter(|&p| sizes[p] > 1e-6 * size)
        .collect();
    let theta = parameters.theta();
    let has_mass = moving.iter().all(|&p| {
        let body = &system.bodies[p];
        if theta[body.mass] <= 0.0 {
            return false;
        }
        // A spin about the mass centre needs a moment of inertia.
        let (v, w) = motion_of(system, p, z);
        let R = &state.poses[p].R;
        let arm = body
            .cm
            .map_or_else(Vec3::zeros, |cm| R * parameters.markers()[cm].p);
        let v_cm = v + w.cross(&arm);
        let local = R.transpose() * w;
        let energy = theta[body.mass] * v_cm.norm_squared() + local.dot(&(body.inertia * local));
        energy > 1e-14 * theta[body.mass] * size * size
    });
    Some(FreeMotion {
        part: system.part_name(PartIx(part)).clone(),
        others,
        motion,
        axis,
        has_mass,
    })
}

/// Velocity of the origin and angular velocity of a part in a motion, ground axes.
pub(super) fn motion_of(system: &System, part: usize, z: &[f64]) -> (Vec3, Vec3) {
    let body = &system.bodies[part];
    let d = &z[body.first..body.first + body.freedoms];
    match body.freedoms {
        6 => (Vec3::new(d[0], d[1], d[2]), Vec3::new(d[3], d[4], d[5])),
        3 => (Vec3::new(d[0], d[1], d[2]), Vec3::zeros()),
        _ => (Vec3::zeros(), Vec3::zeros()),
    }
}

/// A rotation: about the line through two markers of the part where there are such, else through one, else in space.
fn spin(
    system: &System,
    parameters: &Parameters,
    state: &State,
    part: usize,
    v: &Vec3,
    w: &Vec3,
) -> String {
    let pose = &state.poses[part];
    let axis = w.normalize();
    // Point of the axis nearest to the part origin, seen from there.
    let foot = w.cross(v) / w.norm_squared();
    let mut near: Vec<(usize, f64)> = Vec::new();
    for &marker in &system.used {
        if system.owners[marker] != part || system.bodies[part].cm == Some(marker) {
            continue;
        }
        let from = pose.R * parameters.markers()[marker].p - foot;
        let along = from.dot(&axis);
        if (from - along * axis).norm() < 1e-6 * system.length {
            near.push((marker, along));
        }
    }
    near.sort_by(|a, b| a.1.total_cmp(&b.1));
    let label = |marker: usize| format!("MARKER/{}", system.markers[marker].id);
    let pitch = v.dot(&axis).abs() / w.norm();
    let verb = if pitch > 1e-6 * system.length {
        "screws freely about"
    } else {
        "spins freely about"
    };
    match (near.first(), near.last()) {
        (Some(first), Some(last)) if last.1 - first.1 > 1e-6 * system.length => {
            let (a, b) = (first.0.min(last.0), first.0.max(last.0));
            format!("{verb} the line {}-{}", label(a), label(b))
        }
        (Some(only), _) => format!("{verb} {} through {}", direction(&axis), label(only.0)),
        _ => format!("{verb} {}", direction(&axis)),
    }
}

/// `x`, `y`, `z`, or the components of a direction in ground axes.
fn direction(axis: &Vec3) -> String {
    for (k, word) in ["x", "y", "z"].into_iter().enumerate() {
        if axis[k].abs() > 1.0 - 1e-9 {
            return word.to_string();
        }
    }
    format!(
        "the direction ({:.4}, {:.4}, {:.4})",
        axis.x, axis.y, axis.z
    )
}
