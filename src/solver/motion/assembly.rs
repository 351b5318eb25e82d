//! Initial conditions. Positions and velocities satisfy the constraints with the least change of the data; accelerations and forces follow from
//! them.

use super::bordered::plain_weight;
use super::consistent::{Consistent, REMOVED, difference, largest_speed};
use super::error::{MotionError, MotionFailure};
use crate::mechanics::{Mat3, Mat6, Pose, Vec3, Vec6, psi_theta_phi, skew};
use crate::system::{Parameters, PartRates, State, System};

/// Weight of the positions and velocities that the dataset states, relative to the weight of the free ones.
const STATED: f64 = 1e8;
/// Number of passes of the velocity assembly. After each pass, the stated velocities are restored, and the free velocities adapt to them.
const PASSES: usize = 3;
/// Changes of position below this (in model lengths) and rotations below this (in radians) are round-off.
const ROUND_OFF: f64 = 1e-11;
/// Rates of constraint violation above this share of the largest speed are reported as a conflict.
const CONFLICT: f64 = 1e-6;

/// Choice of the velocities from which an assembly starts.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kept {
    /// The velocities stated in the dataset.
    Data,
    /// The present velocities of the state. Momentum is preserved as far as the constraints allow.
    Velocities,
    /// Zero velocities: parts move only as the constraints require.
    Nothing,
}

/// Brings a state onto its constraints.
///
/// Positions change as little as possible, and EXACT coordinates keep their values where the constraints allow it. `kept` selects the
/// velocities to start from. Accelerations, multipliers, variables and rates of states follow. Redundant constraint equations are identified
/// and marked. `step` is the time step of finite differences.
///
/// # Errors
/// Returns [`MotionError`] if the constraints contradict each other or an element has no value; the state is then unchanged.
pub fn assemble(
    system: &System,
    parameters: &Parameters,
    state: &mut State,
    memory: &mut Consistent,
    kept: Kept,
    step: f64,
) -> Result<(), MotionError> {
    let time = state.time;
    let mut new = state.clone();
    let done = attempt(system, parameters, &mut new, memory, kept, step);
    match done {
        Ok(()) => {
            *state = new;
            Ok(())
        }
        Err(reason) => Err(reason.at(time)),
    }
}

fn attempt(
    system: &System,
    parameters: &Parameters,
    state: &mut State,
    memory: &mut Consistent,
    kept: Kept,
    step: f64,
) -> Result<(), MotionFailure> {
    let given = state.velocities.clone();
    state.set_moving();
    if kept != Kept::Velocities || given.is_empty() {
        state.velocities.fill(PartRates::zero());
    }
    state.accelerations.fill(PartRates::zero());
    system.settle_variables(parameters, state, &mut memory.scratch)?;
    system.count_from_drives(parameters, state, &mut memory.scratch)?;
    memory.find_redundant(system, parameters, state)?;
    let anchors: Vec<Pose> = state.poses.clone();
    let plain = plain_weight(system);
    let weights: Vec<Mat6> = (0..system.bodies.len())
        .map(|part| plain + exact_weight(system, part, &anchors[part], &plain))
        .collect();
    memory
        .positions(
            system,
            parameters,
            state,
            Some((&anchors, &|part| weights[part])),
        )
        .map_err(at_the_start)?;
    // Redundancy is determined at the assembled positions. It is determined again if the assembly moved a part, which is rare.
    let moved = anchors.iter().zip(&state.poses).any(|(from, pose)| {
        let apart = difference(pose, from);
        let (place, turn) = (
            apart.fixed_rows::<3>(0).amax(),
            apart.fixed_rows::<3>(3).amax(),
        );
        !(place <= ROUND_OFF * system.length && turn <= ROUND_OFF)
    });
    if moved {
        memory.find_redundant(system, parameters, state)?;
    }
    memory.positions(system, parameters, state, None)?;
    memory
        .check_removed(system, parameters, state, |k| !system.is_nonholonomic[k])
        .map_err(at_the_start)?;
    system.accept(parameters, state, &mut memory.scratch);
    system.settle_variables(parameters, state, &mut memory.scratch)?;
    velocities(system, parameters, state, memory, kept)?;
    memory.accelerations(system, parameters, state, step)
}

/// Converts errors about positions to [`MotionFailure::Inconsistent`], because at the start of a motion they are due to the initial conditions.
fn at_the_start(reason: MotionFailure) -> MotionFailure {
    match reason {
        MotionFailure::NoPosition {
            equation,
            violation,
        }
        | MotionFailure::RedundantViolated {
            equation,
            violation,
        } => MotionFailure::Inconsistent {
            equation,
            violation,
        },
        other => other,
    }
}

fn velocities(
    system: &System,
    parameters: &Parameters,
    state: &mut State,
    memory: &mut Consistent,
    kept: Kept,
) -> Result<(), MotionFailure> {
    let plain = plain_weight(system);
    let unweighted: Vec<Mat6> = (0..system.bodies.len())
        .map(|part| unweighted(system, parameters, state, part))
        .collect();
    match kept {
        Kept::Nothing => memory.velocities(system, parameters, state, &|part| unweighted[part])?,
        Kept::Velocities => {
            let masses: Vec<Mat6> = (0..system.bodies.len())
                .map(|part| {
                    let M = system.mass_matrix(parameters, state, crate::model::PartIx(part));
                    // The small weight lets massless parts follow the parts with mass.
                    M + plain * 1e-9
                })
                .collect();
            memory.velocities(system, parameters, state, &|part| masses[part])?;
        }
        Kept::Data => {
            let stated: Vec<Stated> = (0..system.bodies.len())
                .map(|part| Stated::of(system, parameters, state, part))
                .collect();
            let weights: Vec<Mat6> = stated
                .iter()
                .zip(&unweighted)
                .map(|(stated, plain)| plain + stated.weight(system.metre))
                .collect();
            for (part, stated) in stated.iter().enumerate() {
                state.velocities[part] = stated.velocity();
            }
            for _ in 0..PASSES {
                memory.velocities(system, parameters, state, &|part| weights[part])?;
                // Stated values are restored; the free velocities have adapted to them.
                for (part, stated) in stated.iter().enumerate() {
                    stated.restore(&mut state.velocities[part], system.bodies[part].freedoms);
                }
            }
            memory.velocities(system, parameters, state, &|part| weights[part])?;
        }
    }
    let (equation, violation) = memory.worst_rate(system, state);
    let scale = largest_speed(system, state);
    if violation > CONFLICT * scale {
        return Err(MotionFailure::VelocityConflict {
            equation: system.constraint_equation_name(equation).to_string(),
            violation,
        });
    }
    memory.check_removed_rates(system, parameters, state, REMOVED * scale)
}

/// Returns the weight matrix of free velocities of a part. The squared norm is the sum of two squares: the velocity of the centre of mass in
/// metres per unit of time, and the angular velocity in radians per unit of time. Results of real runs show this weighting (grammar/NOTES.md).
/// It is independent of the units of the model.
fn unweighted(system: &System, parameters: &Parameters, state: &State, part: usize) -> Mat6 {
    let body = &system.bodies[part];
    let c = body.cm.map_or_else(Vec3::zeros, |cm| {
        state.poses[part].R * parameters.markers()[cm].p
    });
    let metre2 = system.metre * system.metre;
    let mut S = Mat6::identity();
    S.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(metre2);
    if body.freedoms == 6 {
        // v + w x c = v - c~ w.
        let c_ = skew(&c);
        S.fixed_view_mut::<3, 3>(0, 3).copy_from(&(c_ * -metre2));
        S.fixed_view_mut::<3, 3>(3, 0).copy_from(&(c_ * metre2));
        let turn = Mat3::identity() - c_ * c_ * metre2;
        S.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
    }
    S
}

/// Returns the additional weight matrix of a part with EXACT coordinates.
fn exact_weight(system: &System, part: usize, pose: &Pose, plain: &Mat6) -> Mat6 {
    let exact = system.bodies[part].start.exact;
    let mut S = Mat6::zeros();
    for k in 0..3 {
        if exact[k] {
            S[(k, k)] = plain[(k, k)] * STATED;
        }
    }
    if exact[3..].iter().all(|e| *e) {
        for k in 3..6 {
            S[(k, k)] = plain[(k, k)] * STATED;
        }
        return S;
    }
    // The columns are the rotation axes of the angles in R = Rz(psi) Rx(theta) Rz(phi). An EXACT angle is held while the other angles may
    // change.
    let [psi, theta, _] = psi_theta_phi(&pose.R);
    let axes = Mat3::from_columns(&[
        Vec3::z(),
        Vec3::new(libm::cos(psi), libm::sin(psi), 0.0),
        Vec3::new(
            libm::sin(psi) * libm::sin(theta),
            -libm::cos(psi) * libm::sin(theta),
            libm::cos(theta),
        ),
    ]);
    if let Some(angles_by_turn) = axes.try_inverse() {
        for k in 0..3 {
            if exact[3 + k] {
                let row = angles_by_turn.row(k).transpose();
                let block = row * row.transpose() * (plain[(3, 3)] * STATED);
                let mut view = S.fixed_view_mut::<3, 3>(3, 3);
                view += block;
            }
        }
    }
    S
}

/// Stated velocity components of a part, as linear functions of (velocity of the origin, angular velocity).
struct Stated {
    /// Tuples (coefficients of the linear function, stated value, true for an angular velocity).
    rows: Vec<(Vec6, f64, bool)>,
}

impl Stated {
    fn of(system: &System, parameters: &Parameters, state: &State, part: usize) -> Self {
        let body = &system.bodies[part];
        let axes = |marker: Option<usize>, usual: Mat3| {
            marker.map_or(usual, |m| {
                state.poses[system.owners[m]].R * parameters.markers()[m].R
            })
        };
        let mut rows = Vec::new();
        if body.freedoms == 0 {
            return Self { rows };
        }
        let c = body.cm.map_or_else(Vec3::zeros, |cm| {
            state.poses[part].R * parameters.markers()[cm].p
        });
        let R = axes(body.start.linear_axes, Mat3::identity());
        for k in 0..3 {
            if let Some(value) = body.start.linear[k] {
                let e: Vec3 = R.column(k).into();
                // e . (v + w x c) = e . v + w . (c x e).
                let turn = if body.freedoms == 6 {
                    c.cross(&e)
                } else {
                    Vec3::zeros()
                };
                rows.push((
                    Vec6::new(e.x, e.y, e.z, turn.x, turn.y, turn.z),
                    value,
                    false,
                ));
            }
        }
        if body.freedoms == 6 {
            let R = axes(body.start.angular_axes, state.poses[part].R);
            for k in 0..3 {
                if let Some(value) = body.start.angular[k] {
                    let e: Vec3 = R.column(k).into();
                    rows.push((Vec6::new(0.0, 0.0, 0.0, e.x, e.y, e.z), value, true));
                }
            }
        }
        Self { rows }
    }

    /// Returns the weight matrix of the stated components. `metre` is the number of metres per length unit of the model.
    fn weight(&self, metre: f64) -> Mat6 {
        let mut S = Mat6::zeros();
        for (row, _, angular) in &self.rows {
            let unit = if *angular { 1.0 } else { metre * metre };
            S += row * row.transpose() * (unit * STATED);
        }
        S
    }

    /// Returns the velocity that has the stated components and is zero in all other directions.
    fn velocity(&self) -> PartRates {
        let mut velocity = PartRates::zero();
        for (row, value, angular) in &self.rows {
            if *angular {
                velocity.angular += Vec3::new(row[3], row[4], row[5]) * *value;
            }
        }
        self.restore(&mut velocity, 6);
        velocity
    }

    /// Changes a velocity as little as possible so that it has the stated components: first the angular velocity, then the velocity of the
    /// origin.
    fn restore(&self, velocity: &mut PartRates, freedoms: usize) {
        for (row, value, angular) in &self.rows {
            let turn = Vec3::new(row[3], row[4], row[5]);
            if *angular && freedoms == 6 {
                velocity.angular += turn * (value - turn.dot(&velocity.angular));
            }
        }
        for (row, value, angular) in &self.rows {
            let (e, turn) = (
                Vec3::new(row[0], row[1], row[2]),
                Vec3::new(row[3], row[4], row[5]),
            );
            if !angular {
                let now = e.dot(&velocity.linear) + turn.dot(&velocity.angular);
                velocity.linear += e * (value - now);
            }
        }
    }
}
