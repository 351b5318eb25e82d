//! What the equations of motion need besides those of statics, and what they leave out.

use std::collections::BTreeSet;

use crate::diagnostic::{Code, Diagnostic};
use crate::function::{Degree, Input, RateAxis, RateKind};
use crate::model::{Model, PartKind};
use crate::system::compiled_function::Source;
use crate::system::structure::Drive;
use crate::system::{Name, System};

/// The median mass of the bodies that have one; one if none has.
pub(super) fn reference_mass(model: &Model) -> f64 {
    let bodies = model.parts.iter();
    let mut masses: Vec<f64> = bodies
        .filter(|part| matches!(part.kind, PartKind::Rigid | PartKind::PointMass))
        .map(|part| part.mass / model.units.ucf)
        .filter(|mass| *mass > 0.0)
        .collect();
    masses.sort_by(f64::total_cmp);
    masses.get(masses.len() / 2).copied().unwrap_or(1.0)
}

/// Statements that act in motion and that the equations of motion do not have.
pub(super) fn not_in_motion(system: &System) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut refuse = |owner: &Name, message: String| {
        found.push(
            Diagnostic::error(Code::NotSolvedNatively, message)
                .about(owner.object())
                .help("real ADAMS solves it; a static or quasi-static simulation does without"),
        );
    };
    for joint in system.joints.iter().filter(|joint| joint.active) {
        match joint.drive {
            Drive::Rate(drive) if !only_of_time(system, drive.function) => refuse(
                &joint.name,
                format!(
                    "{} prescribes a rate by more than the time: it is not integrated",
                    joint.name
                ),
            ),
            Drive::Function(function) => {
                if let Some(what) = unsteady(system, function, false) {
                    refuse(&joint.name, reading(&joint.name, what));
                }
            }
            _ => {}
        }
    }
    for condition in system.conditions.iter().filter(|c| c.active) {
        let of_velocities = system.of_velocities[condition.equation];
        if let Some(what) = unsteady(system, condition.function, of_velocities) {
            refuse(&condition.name, reading(&condition.name, what));
        } else if of_velocities
            && degree_in_velocities(system, condition.function) != Degree::Linear
        {
            refuse(
                &condition.name,
                format!(
                    "the function of {} is not linear in the velocities",
                    condition.name
                ),
            );
        }
    }
    found
}

fn reading(owner: &Name, what: &str) -> String {
    format!(
        "the function of {owner} reads {what}: in motion it may know places, the time and variables of the time, that of a GCON velocities too"
    )
}

fn only_of_time(system: &System, function: usize) -> bool {
    let mut sources = system.functions[function].sources.iter();
    sources.all(|source| {
        matches!(
            source,
            Source::Time | Source::Mode | Source::Constant(_) | Source::Sensor(_)
        )
    })
}

/// How a function depends on the velocities that it reads: VM and WM are not linear.
fn degree_in_velocities(system: &System, function: usize) -> Degree {
    let of = |input: &Input| match input {
        Input::Rate(measure) if measure.axis == RateAxis::Magnitude => Degree::Higher,
        Input::Rate(_) => Degree::Linear,
        _ => Degree::Nothing,
    };
    let program = system.functions[function].program.as_ref();
    program.map_or(Degree::Nothing, |program| program.degree(of))
}

/// What a constrained function reads, itself or through variables, whose rates do not follow from those of the parts; velocities are allowed
/// where it constrains these.
fn unsteady(system: &System, function: usize, of_velocities: bool) -> Option<&'static str> {
    let mut seen = BTreeSet::new();
    let mut open = vec![(function, false)];
    while let Some((function, inside)) = open.pop() {
        if !seen.insert(function) {
            continue;
        }
        for source in &system.functions[function].sources {
            match source {
                Source::Moved(measure) => {
                    let velocity =
                        matches!(measure.kind, RateKind::Velocity | RateKind::AngularVelocity);
                    match (velocity, inside) {
                        (true, false) if of_velocities => {}
                        (true, true) if of_velocities => {
                            return Some("a variable of velocities");
                        }
                        _ => return Some("a velocity or an acceleration"),
                    }
                }
                Source::Force(_) | Source::Friction(..) => return Some("a force"),
                Source::State(_) | Source::StateRate(..) | Source::Output(_) => {
                    return Some("a dynamic state");
                }
                Source::Variable(k) => open.push((system.variables[*k].function, true)),
                Source::Measure(..) if inside => return Some("a variable of places"),
                Source::Time
                | Source::Mode
                | Source::Measure(..)
                | Source::Constant(_)
                | Source::Sensor(_) => {}
            }
        }
    }
    None
}
