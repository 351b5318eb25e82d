//! Quantities from the tangent stiffness at an equilibrium on the rig: compliance, reactions, rates and instant axes.

use nalgebra::DMatrix;

use super::compiled::{Compiled, Fitted};
use super::config::{AxisMethod, Config};
use super::inputs::Drive;
use super::rig::FoundWheel;
use super::wheel_rate::WheelRate;
use super::{Compliance, Mat12, SteerAxis};
use admire_solver::mechanics::{Vec3, Vec6};
use admire_solver::model::{MarkerIx, Model, PartIx};
use admire_solver::statics::{Direction, SolveError, Tangent, point_change};
use admire_solver::system::{Parameters, Quantity, Slot, State, System};

/// Smallest wheel rate in N/m at which a wheel counts as supported by springs. Below it, only the motion of the rig holds the wheel.
const LEAST_RATE: f64 = 1e-3;

/// Quantities from the tangent stiffness at an equilibrium.
pub(super) struct Derivatives {
    /// Compliance of the wheel centres. `None` where only a motion holds a wheel up, as in a deck of rigid joints without springs.
    pub compliance: Option<Compliance>,
    /// Reaction force of the motion that holds the height of each wheel.
    pub reactions: Vec<f64>,
    /// Number of zero-stiffness motions; they are held fixed.
    pub deficiency: usize,
    /// Motion and load of each wheel per unit of the driven variable.
    pub rates: Vec<WheelRate>,
    /// Instant steer axis of each wheel.
    pub axes: Vec<Option<SteerAxis>>,
    /// Motion and load of each wheel per unit of each direction of [`Bench::differentiate`](super::Bench::differentiate).
    pub along: Vec<Vec<WheelRate>>,
    /// Derivative of each probe along each of these directions.
    pub probes: Vec<Vec<f64>>,
}

impl Derivatives {
    /// Computes the derivatives from the responses to unit loads at the wheel centres.
    ///
    /// Motions that hold the heights are released by superposition. With responses u_f to a load and u_h to a unit of held height, and with
    /// the height reactions r_f and r_h in these two responses, the released response is `u = u_f - u_h (r_h)^-1 r_f`.
    pub(crate) fn of(
        compiled: &mut Compiled,
        config: &Config,
        parameters: &Parameters,
        state: &State,
        (drive, along): (Option<&Drive>, &[Drive]),
        found: &[FoundWheel],
    ) -> Result<Self, SolveError> {
        let changes: Vec<Direction> = along
            .iter()
            .zip(&compiled.directions)
            .map(|(inputs, own)| {
                let mut all = own.clone();
                all.slots.extend(compiled.driven(inputs));
                all
            })
            .collect();
        let Compiled {
            system,
            solver,
            scratch,
            wheels,
            model,
            steering,
            probes,
            ..
        } = compiled;
        let (system, model, wheels): (&System, &Model, &[Fitted]) = (system, model, wheels);
        let m = wheels.len();
        let mut tangent = solver.tangent(system, parameters, state)?;
        // Reactions of the height motions along their own axis, with their gradients.
        let (mut reactions, mut gradients) = (vec![0.0; m], Vec::new());
        {
            let mut look = system.evaluate(parameters, state, scratch)?;
            for (n, wheel) in wheels.iter().enumerate() {
                let mut gradient = vec![0.0; system.unknowns()];
                if let Some((_, constraint)) = wheel.motion {
                    let up = config.frame.to_deck(&Vec3::z());
                    for k in 0..3 {
                        let quantity = Quantity::Constraint(constraint, k);
                        reactions[n] += up[k] * look.quantity(quantity)?;
                        if up[k] != 0.0 {
                            let mut own = vec![0.0; gradient.len()];
                            look.quantity_by_unknowns(quantity, &mut own)?;
                            gradient
                                .iter_mut()
                                .zip(own)
                                .for_each(|(a, b)| *a += up[k] * b);
                        }
                    }
                }
                gradients.push(gradient);
            }
        }
        let locks: Vec<(PartIx, Vec3, MarkerIx)> = wheels
            .iter()
            .zip(found)
            .map(|(wheel, found)| {
                let marker = found.travel_lock.unwrap_or(wheel.centre);
                let frame = &model.markers[marker.0];
                (frame.part, frame.qp, marker)
            })
            .collect();
        // Rows of a response: six displacements of each wheel, one reaction of each wheel, one lock height of each wheel.
        let rows = 8 * m;
        let read = |dx: &[f64]| -> Vec<f64> {
            let mut out = Vec::with_capacity(rows);
            for wheel in wheels {
                let local = model.markers[wheel.centre.0].qp;
                let shift = point_change(system, state, wheel.part, &local, dx);
                let unknowns = &dx[system.part_unknowns(wheel.part)];
                let turn = Vec3::new(unknowns[3], unknowns[4], unknowns[5]);
                out.extend(config.frame.vector(&shift).iter());
                out.extend(config.frame.vector(&turn).iter());
            }
            for gradient in &gradients {
                out.push(gradient.iter().zip(dx).map(|(a, b)| a * b).sum());
            }
            for (part, local, _) in &locks {
                let shift = point_change(system, state, *part, local, dx);
                out.push(config.frame.vector(&shift).z);
            }
            out
        };
        let by_wrench = |tangent: &mut Tangent, i: MarkerIx, g: MarkerIx, k: usize| {
            read(&tangent.by_wrench(system, parameters, state, (i, g), &Vec6::ith(k, 1.0)))
        };
        let mut loads = DMatrix::zeros(rows, 6 * m);
        for (n, wheel) in wheels.iter().enumerate() {
            for k in 0..6 {
                let column = by_wrench(&mut tangent, wheel.centre, wheel.ground, k);
                loads.column_mut(6 * n + k).copy_from_slice(&column);
            }
        }
        let held: Vec<Slot> = wheels
            .iter()
            .filter_map(|w| w.motion.map(|m| m.0))
            .collect();
        let mut heights = DMatrix::zeros(rows, held.len());
        for (n, slot) in held.iter().enumerate() {
            let dx = tangent.by_slot(system, parameters, state, *slot)?;
            heights.column_mut(n).copy_from_slice(&read(&dx));
        }
        let stiffness = heights.rows(6 * m, held.len()).into_owned();
        let least = LEAST_RATE * model.units.length.si / model.units.force.si;
        let inverse = (held.len() == m && stiffness.norm() > least)
            .then(|| stiffness.try_inverse())
            .flatten();
        // Releases the heights: adds the height changes that keep the height reactions unchanged.
        let release = |columns: &DMatrix<f64>| -> DMatrix<f64> {
            if held.is_empty() {
                return columns.clone();
            }
            let Some(inverse) = &inverse else {
                return columns * f64::NAN;
            };
            columns - &heights * (inverse * columns.rows(6 * m, m))
        };
        let free = release(&loads);
        let mut matrix = Mat12::zeros();
        let mut present = [false; 2];
        for (a, row) in wheels.iter().enumerate() {
            present[row.side.index()] = true;
            for (b, column) in wheels.iter().enumerate() {
                let block = free.view((6 * a, 6 * b), (6, 6));
                matrix
                    .fixed_view_mut::<6, 6>(6 * row.side.index(), 6 * column.side.index())
                    .copy_from(&block);
            }
        }
        let defined = matrix.iter().all(|entry| entry.is_finite());
        let compliance = defined.then_some(Compliance { matrix, present });
        let rates = match drive {
            None => Vec::new(),
            Some(drive) => {
                let mut total = vec![0.0; rows];
                let mut add = |factor: f64, column: &[f64]| {
                    total
                        .iter_mut()
                        .zip(column)
                        .for_each(|(a, b)| *a += factor * b);
                };
                let mut own_load = vec![0.0; m];
                for (n, wheel) in wheels.iter().enumerate() {
                    let k = wheel.side.index();
                    for (slot, factor) in wheel.loads.iter().zip(drive.loads[k]) {
                        if factor != 0.0 {
                            let dx = tangent.by_slot(system, parameters, state, *slot)?;
                            add(factor, &read(&dx));
                        }
                    }
                    own_load[n] = drive.loads[k][2];
                    if let (Some((slot, _)), true) = (wheel.motion, drive.height[k] != 0.0) {
                        let dx = tangent.by_slot(system, parameters, state, slot)?;
                        add(drive.height[k], &read(&dx));
                    }
                }
                if let (Some(slot), true) = (*steering, drive.steer != 0.0) {
                    let dx = tangent.by_slot(system, parameters, state, slot)?;
                    add(drive.steer, &read(&dx));
                }
                (0..m)
                    .map(|n| WheelRate {
                        motion: Vec6::from_column_slice(&total[6 * n..6 * n + 6]),
                        load: own_load[n] + total[6 * m + n],
                    })
                    .collect()
            }
        };
        let axes = if matches!(config.axis_method, AxisMethod::Geometric) {
            Vec::new()
        } else {
            // If motions hold all wheel centres, these motions are the travel locks.
            let locked_at_centre =
                held.len() == m && found.iter().all(|wheel| wheel.travel_lock.is_none());
            let vertical = {
                let mut columns = DMatrix::zeros(rows, m);
                for (n, (_, _, marker)) in locks.iter().enumerate() {
                    let column = by_wrench(&mut tangent, *marker, wheels[n].ground, 2);
                    columns.column_mut(n).copy_from_slice(&column);
                }
                release(&columns)
            };
            let steered = match (config.axis_method, *steering) {
                (AxisMethod::InstantMoment, _) => {
                    let mut columns = DMatrix::zeros(rows, m);
                    for n in 0..m {
                        columns.column_mut(n).copy_from(&free.column(6 * n + 5));
                    }
                    Some(columns)
                }
                (_, Some(slot)) => {
                    let dx = tangent.by_slot(system, parameters, state, slot)?;
                    let one = DMatrix::from_column_slice(rows, 1, &read(&dx));
                    let one = if locked_at_centre { one } else { release(&one) };
                    Some(DMatrix::from_fn(rows, m, |i, _| one[(i, 0)]))
                }
                (_, None) => None,
            };
            let locked = steered.and_then(|steered| {
                if locked_at_centre && config.axis_method != AxisMethod::InstantMoment {
                    return Some(steered);
                }
                // The lock forces keep the lock heights: [v; w] = c_steer - c_lock (c_lock.lock)^-1 c_steer.lock.
                let zz = vertical.rows(7 * m, m).into_owned().try_inverse()?;
                Some(&steered - &vertical * (zz * steered.rows(7 * m, m)))
            });
            wheels
                .iter()
                .enumerate()
                .map(|(n, wheel)| {
                    let locked = locked.as_ref()?;
                    let column: Vec<f64> = (0..6).map(|k| locked[(6 * n + k, n)]).collect();
                    let motion = Vec6::from_column_slice(&column);
                    let frame = &model.markers[wheel.centre.0];
                    let centre = state.poses[wheel.part.0].point(&frame.qp);
                    SteerAxis::of_motion(&config.frame.vector(&centre), &motion)
                })
                .collect()
        };
        let here = (system, parameters, state);
        let dx = tangent.along(here, scratch, &changes)?;
        // The rig's own markers carry the motions that hold the heights, so a change of the deck changes their reactions only through the
        // unknowns.
        let each = || dx.chunks(system.unknowns().max(1));
        let probes = each()
            .zip(&changes)
            .map(|(dx, own)| probes.changes(here, scratch, dx, own))
            .collect::<Result<_, _>>()?;
        let along = each()
            .zip(along)
            .map(|(dx, inputs)| {
                let total = read(dx);
                let of = |n: usize| WheelRate {
                    motion: Vec6::from_column_slice(&total[6 * n..6 * n + 6]),
                    load: inputs.loads[wheels[n].side.index()][2] + total[6 * m + n],
                };
                (0..m).map(of).collect()
            })
            .collect();
        Ok(Self {
            along,
            probes,
            compliance,
            deficiency: tangent.deficiency(),
            reactions,
            rates,
            axes,
        })
    }
}
