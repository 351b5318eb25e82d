//! Motions without stiffness and redundant constraint equations, described in the user's terms.

use nalgebra::DMatrix;

use super::report::{FreeMotion, Weak};
use crate::linear::{Lu, Matrix};
use crate::mechanics::Vec3;
use crate::mechanics::eigen::symmetric_eigen;
use crate::model::PartIx;
use crate::system::{Parameters, State, System};

/// Parts with mass count as being at rest if their kinetic energy is below this share of the energy that all parts with the largest mass would have.
const ROUND_OFF: f64 = 1e-20;
/// A stiffness is round-off if it is below this share of the summed magnitudes of its terms.
const LOST: f64 = 1e-14;
/// Relative round-off of a stiffness in which many terms cancel: about a thousand roundings.
const ASSEMBLED: f64 = 1e3 * f64::EPSILON;
/// The motions of the parts in a null vector count as zero if they are below this share of its reactions. Such a null vector describes undetermined
/// reactions.
pub(super) const UNDETERMINED: f64 = 1e-12;
/// A motion counts as massless if its kinetic energy is below this share of the largest energy possible.
const NO_INERTIA: f64 = 1e-14;

/// Returns, for every constraint equation, whether it depends on the equations before it. `J` is the whole Jacobian, not factored.
pub(super) fn redundant_equations(system: &System, J: &Matrix) -> Vec<bool> {
    let first = system.first_equation;
    let rows: Vec<(u32, u32, f64)> = J
        .entries()
        .filter(|(row, column, _)| *column < first && (first..system.first_variable).contains(row))
        .map(|(row, column, value)| ((row - first) as u32, column as u32, value))
        .collect();
    let mut redundant = system.redundant_rows(&rows);
    // Nonholonomic constraints have no entries in the static Jacobian, but they are not redundant.
    for (redundant, of_velocities) in redundant.iter_mut().zip(&system.is_nonholonomic) {
        *redundant &= !of_velocities;
    }
    redundant
}

/// Wording for the description of a motion.
pub(super) struct Words {
    along: &'static str,
    pub about: &'static str,
    screw: &'static str,
    /// Parts and rotations below this share of the largest motion are omitted from the description.
    share: f64,
}

pub(super) const FREE: Words = Words {
    along: "is free to translate along",
    about: "spins freely about",
    screw: "is free to perform a screw motion along",
    share: 1e-6,
};

const WEAK: Words = Words {
    along: "has almost no stiffness along",
    about: "has almost no stiffness about",
    screw: "has almost no stiffness in a screw motion along",
    share: 1e-6,
};

const SOFT: Words = Words {
    along: "moves along",
    about: "turns about",
    screw: "moves in a screw motion along",
    share: 0.1,
};

/// Describes a free motion `z`, which is a null vector of the Jacobian `J`. Returns `None` if no part moves in `z`; multipliers or variables
/// are then undetermined.
pub(super) fn free_motion(
    system: &System,
    parameters: &Parameters,
    state: &State,
    J: &Matrix,
    z: &[f64],
) -> Option<FreeMotion> {
    let (mut motion, part, turns) = moving(system, parameters, state, z, &FREE)?;
    let (v, w) = motion_of(system, part, z);
    let (size, first) = if turns { (w.norm(), 3) } else { (v.norm(), 0) };
    // The stiffness of the same part in the same kind of unknown (translation or rotation).
    let own = system.bodies[part].first + first;
    let own = own..own + 3;
    let squares = J
        .entries()
        .filter(|(row, column, _)| own.contains(row) && own.contains(column))
        .map(|(_, _, value)| value * value);
    let largest = squares.sum::<f64>().sqrt();
    let weak = stiffness_along(system, J, z).map(|work| {
        let stiffness = work / (size * size);
        Weak {
            stiffness,
            share: stiffness / largest,
        }
    });
    if let Some(weak) = weak.filter(|weak| weak.share > ASSEMBLED) {
        (motion, ..) = moving(system, parameters, state, z, &WEAK)?;
        motion.weak = Some(weak);
    }
    Some(motion)
}

/// Returns twice the elastic energy of a motion `z`, computed with the Jacobian `J`. Returns `None` if this energy is round-off.
fn stiffness_along(system: &System, J: &Matrix, z: &[f64]) -> Option<f64> {
    let (mut work, mut size) = (0.0, 0.0);
    for (row, column, value) in J.entries() {
        if row < system.first_equation {
            work -= z[row] * value * z[column];
            size += (z[row] * value * z[column]).abs();
        }
    }
    (work > LOST * size).then_some(work)
}

/// Describes a motion with little or negative stiffness.
pub(super) fn soft_motion(
    system: &System,
    parameters: &Parameters,
    state: &State,
    z: &[f64],
) -> Option<FreeMotion> {
    moving(system, parameters, state, z, &SOFT).map(|(motion, ..)| motion)
}

/// Returns the description of a motion, the index of the part that moves most, and whether that part rotates. Returns `None` if no part moves.
fn moving(
    system: &System,
    parameters: &Parameters,
    state: &State,
    z: &[f64],
    words: &Words,
) -> Option<(FreeMotion, usize, bool)> {
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
    // Multipliers scale like forces. Motions far below the round-off of the multipliers count as zero.
    let multipliers = z[system.first_equation..]
        .iter()
        .fold(0.0_f64, |a, b| a.max(b.abs()));
    if size < UNDETERMINED * multipliers {
        return None;
    }
    let (v, w) = motion_of(system, part, z);
    let turns = w.norm() * system.length > words.share * size;
    let axis = if turns { w.normalize() } else { v.normalize() };
    let motion = if turns {
        spin(system, parameters, state, part, (&v, &w), words)
    } else {
        format!("{} {}", words.along, direction(&axis))
    };
    let others = (0..system.bodies.len())
        .filter(|&other| other != part && sizes[other] > words.share * size)
        .map(|other| system.part_name(PartIx(other)).clone())
        .collect();
    let motion = FreeMotion {
        part: system.part_name(PartIx(part)).clone(),
        others,
        motion,
        axis,
        weak: None,
    };
    Some((motion, part, turns))
}

/// Returns all motions without stiffness. If a motion without stiffness has no mass either, it is returned as an error, because the positions
/// of its parts are then undetermined.
///
/// A motion is massless if its kinetic energy is zero, including the energy of parts that joints move along with it. Any combination of the
/// null vectors may be massless. Therefore the principal axes of the kinetic energy are examined.
pub(super) fn free_motions(
    system: &System,
    parameters: &Parameters,
    state: &State,
    J: &Matrix,
    factors: &Lu,
) -> Result<Vec<FreeMotion>, Box<FreeMotion>> {
    let (mut vectors, mut motions) = (Vec::new(), Vec::new());
    for m in 0..factors.deficiency() {
        let mut z = factors.null_vector(m);
        if let Some(motion) = free_motion(system, parameters, state, J, &z) {
            let (_, size) = energies(system, parameters, state, (&z, &z));
            let scale = 1.0 / size.sqrt().max(f64::MIN_POSITIVE);
            for x in &mut z {
                *x *= scale;
            }
            vectors.push(z);
            motions.push(motion);
        }
    }
    let n = vectors.len();
    let pair = |a: usize, b: usize| energies(system, parameters, state, (&vectors[a], &vectors[b]));
    let energy = DMatrix::from_fn(n, n, |a, b| pair(a, b).0);
    let size = DMatrix::from_fn(n, n, |a, b| pair(a, b).1);
    // Scales the axes so that all motions have the same size, then turns the axes to the principal axes of the energy.
    let alike = symmetric_eigen(size);
    let mut axes = alike.eigenvectors;
    for (mut axis, square) in axes.column_iter_mut().zip(alike.eigenvalues.iter()) {
        axis /= square.max(f64::EPSILON).sqrt();
    }
    let axes = &axes * symmetric_eigen(axes.transpose() * energy * &axes).eigenvectors;
    for axis in axes.column_iter() {
        let mut z = vec![0.0; vectors[0].len()];
        for (weight, vector) in axis.iter().zip(&vectors) {
            z.iter_mut().zip(vector).for_each(|(z, x)| *z += weight * x);
        }
        if is_massless(system, parameters, state, &z)
            && let Some(motion) = free_motion(system, parameters, state, J, &z)
        {
            return Err(Box::new(motion));
        }
    }
    Ok(motions)
}

/// Returns twice the mutual kinetic energy of two motions. The second value is the same quantity for parts with unit mass and the model's length as
/// their radius of gyration.
fn energies(
    system: &System,
    parameters: &Parameters,
    state: &State,
    (a, b): (&[f64], &[f64]),
) -> (f64, f64) {
    let (mut energy, mut size) = (0.0, 0.0);
    for (p, body) in system
        .bodies
        .iter()
        .enumerate()
        .filter(|(_, b)| b.freedoms > 0)
    {
        let [(v_a, w_a), (v_b, w_b)] =
            [a, b].map(|z| at_mass_centre(system, parameters, state, p, z));
        // IP is in the axes of the CM marker.
        let R = body.cm.map_or(state.poses[p].R, |cm| {
            state.poses[p].R * parameters.markers()[cm].R
        });
        let (local_a, local_b) = (R.transpose() * w_a, R.transpose() * w_b);
        energy +=
            parameters.theta()[body.mass] * v_a.dot(&v_b) + local_a.dot(&(body.inertia * local_b));
        size += v_a.dot(&v_b) + system.length * system.length * w_a.dot(&w_b);
    }
    (energy, size)
}

/// Returns the velocity of the mass centre and the angular velocity of a part in a motion, in ground axes.
fn at_mass_centre(
    system: &System,
    parameters: &Parameters,
    state: &State,
    part: usize,
    z: &[f64],
) -> (Vec3, Vec3) {
    let (v, w) = motion_of(system, part, z);
    let reference = system.local_reference(state, part);
    let cm = system.bodies[part].cm;
    let local = cm.map_or(reference, |cm| parameters.markers()[cm].p);
    let arm = state.poses[part].R * (local - reference);
    (v + w.cross(&arm), w)
}

/// Returns true if the kinetic energy of a motion is negligible. It is compared with the energy of parts that have the same mass and the
/// model's length as their radius of gyration.
fn is_massless(system: &System, parameters: &Parameters, state: &State, z: &[f64]) -> bool {
    let (energy, size) = energies(system, parameters, state, (z, z));
    let mut most = 0.0;
    for (p, body) in system
        .bodies
        .iter()
        .enumerate()
        .filter(|(_, b)| b.freedoms > 0)
    {
        let (v, w) = at_mass_centre(system, parameters, state, p, z);
        let mass = parameters.theta()[body.mass].max(0.0);
        let square = v.norm_squared() + system.length * system.length * w.norm_squared();
        most += mass * square;
    }
    let heaviest = system.bodies.iter().filter(|b| b.freedoms > 0);
    let heaviest = heaviest.fold(0.0_f64, |a, b| a.max(parameters.theta()[b.mass]));
    // If the parts with mass move only by round-off, their mass does not count.
    most <= ROUND_OFF * heaviest * size || energy <= NO_INERTIA * most
}

/// Returns the velocity of the reference point and the angular velocity of a part in a motion, in ground axes.
pub(super) fn motion_of(system: &System, part: usize, z: &[f64]) -> (Vec3, Vec3) {
    let body = &system.bodies[part];
    let d = &z[body.first..body.first + body.freedoms];
    match body.freedoms {
        6 => (Vec3::new(d[0], d[1], d[2]), Vec3::new(d[3], d[4], d[5])),
        3 => (Vec3::new(d[0], d[1], d[2]), Vec3::zeros()),
        _ => (Vec3::zeros(), Vec3::zeros()),
    }
}

/// Describes a rotation of a part. The axis is named by two markers of the part on it, otherwise by its direction and one marker on it,
/// otherwise by its direction alone.
fn spin(
    system: &System,
    parameters: &Parameters,
    state: &State,
    part: usize,
    (v, w): (&Vec3, &Vec3),
    words: &Words,
) -> String {
    let pose = &state.poses[part];
    let reference = system.local_reference(state, part);
    let axis = w.normalize();
    // Point of the rotation axis nearest to the reference point, relative to the reference point.
    let foot = w.cross(v) / w.norm_squared();
    let mut near: Vec<(usize, f64)> = Vec::new();
    for &marker in &system.used {
        if system.owners[marker] != part || system.bodies[part].cm == Some(marker) {
            continue;
        }
        let from = pose.R * (parameters.markers()[marker].p - reference) - foot;
        let along = from.dot(&axis);
        if (from - along * axis).norm() < 1e-6 * system.length {
            near.push((marker, along));
        }
    }
    near.sort_by(|a, b| a.1.total_cmp(&b.1));
    let label = |marker: usize| format!("MARKER/{}", system.markers[marker].id);
    let pitch = v.dot(&axis).abs() / w.norm();
    let verb = if pitch > 1e-6 * system.length {
        words.screw
    } else {
        words.about
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

/// Returns `x`, `y` or `z` if the axis is parallel to that ground axis, otherwise the components of the axis in ground axes.
fn direction(axis: &Vec3) -> String {
    for (k, word) in ["x", "y", "z"].into_iter().enumerate() {
        if axis[k].abs() > 1.0 - 1e-9 {
            return word.to_string();
        }
    }
    format!(
        "the ground direction ({:.4}, {:.4}, {:.4})",
        axis.x, axis.y, axis.z
    )
}
