//! Additional data for the equations of motion, and the statements that the equations of motion do not include.

use std::collections::{BTreeMap, BTreeSet};

use crate::function::{Degree, RateAxis};
use crate::model::{Model, PartKind};
use crate::system::compiled_function::Source;
use crate::system::structure::{ParameterSource, StateRhs};
use crate::system::{Name, System};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Returns the median mass of the bodies with nonzero mass, or one if there is no such body.
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

/// Returns diagnostics for statements that would act in motion but are not included in the equations of motion.
pub(super) fn not_in_motion(system: &System) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut refuse = |owner: &Name, message: String| {
        found.push(
            Diagnostic::error(Code::NotSolvedNatively, message)
                .about(owner.object())
                .help("real ADAMS solves it; a static or quasi-static simulation does not need it"),
        );
    };
    for joint in system.joints.iter().filter(|joint| joint.active) {
        match joint.drive {
            ParameterSource::Rate(drive) if !system.reads().only_time(drive.function) => refuse(
                &joint.name,
                format!(
                    "{} prescribes a velocity or acceleration that depends on more than TIME; the built-in solver does not integrate it",
                    joint.name
                ),
            ),
            ParameterSource::Function(function) => {
                if let Some(what) = unsteady(system, function, false) {
                    refuse(&joint.name, reading(&joint.name, what));
                }
            }
            _ => {}
        }
    }
    for condition in system.conditions.iter().filter(|c| c.active) {
        let of_velocities = system.is_nonholonomic[condition.equation];
        if let Some(what) = unsteady(system, condition.function, of_velocities) {
            refuse(&condition.name, reading(&condition.name, what));
        } else if of_velocities
            && degree_in_velocities(system, condition.function) != Degree::Linear
        {
            refuse(
                &condition.name,
                format!(
                    "the function of {} is not linear in the velocities; the built-in solver requires this",
                    condition.name
                ),
            );
        }
    }
    found
}

fn reading(owner: &Name, what: &str) -> String {
    format!(
        "the function of {owner} reads {what}: in kinematic and dynamic simulations it may read only positions, TIME, and states and variables that depend on these; the function of a GCON may also read velocities"
    )
}

/// Returns the polynomial degree of a function in the velocities that it reads. The magnitudes VM and WM count as nonlinear.
fn degree_in_velocities(system: &System, function: usize) -> Degree {
    let mut degrees = BTreeMap::new();
    for read in system.in_turn(function) {
        let function = &system.functions[read];
        let Some(program) = function.program.as_ref() else {
            continue;
        };
        let mut sources = function.sources.iter().map(|source| match source {
            Source::Moved(measure) if measure.axis == RateAxis::Magnitude => Degree::Higher,
            Source::Moved(_) => Degree::Linear,
            Source::Variable(k) => {
                let function = system.reads().explicit(*k);
                let known = function.and_then(|f| degrees.get(&f));
                known.copied().unwrap_or(Degree::Nothing)
            }
            _ => Degree::Nothing,
        });
        let degree = program.degree(|_| sources.next().unwrap_or(Degree::Nothing));
        degrees.insert(read, degree);
    }
    degrees.remove(&function).unwrap_or(Degree::Nothing)
}

/// Describes an input of a constrained function if the rate of that input does not follow from the part velocities. Returns `None` if the
/// function reads no such input, neither itself nor through variables.
///
/// If `of_velocities` is set, the function constrains velocities, and reading velocities is allowed.
fn unsteady(system: &System, function: usize, of_velocities: bool) -> Option<&'static str> {
    let mut seen = BTreeSet::new();
    // Description to report if positions or velocities are read within a variable that reads itself.
    let mut open = vec![(function, None)];
    let read = |k: usize, inside: Option<&'static str>| {
        let variable = &system.variables[k];
        let itself = variable.unknown.map(|_| "a variable that reads itself");
        (variable.function, inside.or(itself))
    };
    while let Some((function, inside)) = open.pop() {
        if !seen.insert(function) {
            continue;
        }
        for source in &system.functions[function].sources {
            match source {
                Source::Moved(measure) => {
                    if inside.is_some() {
                        return inside;
                    }
                    if !of_velocities || measure.kind.is_second() {
                        return Some("a velocity or an acceleration");
                    }
                }
                Source::Force(_) | Source::Friction(..) => return Some("a force"),
                Source::StateRate(..) => return Some("the rate of a dynamic state"),
                Source::State(k) => {
                    if let Some(what) = unsteady_state(system, *k, of_velocities) {
                        return Some(what);
                    }
                }
                Source::Output((by_state, by_variable)) => {
                    for (k, _) in by_state {
                        if let Some(what) = unsteady_state(system, *k, of_velocities) {
                            return Some(what);
                        }
                    }
                    open.extend(by_variable.iter().map(|(k, _)| read(*k, inside)));
                }
                Source::Variable(k) => open.push(read(*k, inside)),
                Source::Measure(..) if inside.is_some() => return inside,
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

/// Returns the functions of the variables in a linear combination.
fn functions_of(system: &System, by_variable: &[(usize, f64)]) -> impl Iterator<Item = usize> {
    let variables = by_variable.iter();
    variables.map(|(k, _)| system.variables[*k].function)
}

/// Describes an input of a state's rate that does not follow from positions and time. Returns `None` if there is no such input. With
/// `of_velocities`, the input may also follow from velocities.
fn unsteady_state(system: &System, state: usize, of_velocities: bool) -> Option<&'static str> {
    let mut seen = BTreeSet::new();
    let (mut states, mut functions) = (vec![state], Vec::new());
    loop {
        while let Some(state) = states.pop() {
            let equation = &system.states[state];
            if !seen.insert((state, true)) {
                continue;
            }
            if equation.implicit {
                return Some("an implicit dynamic state");
            }
            match &equation.moving {
                StateRhs::Held => {}
                StateRhs::Function(function) => functions.push(*function),
                StateRhs::Linear(by_state, by_variable) => {
                    states.extend(by_state.iter().map(|(k, _)| *k));
                    functions.extend(functions_of(system, by_variable));
                }
            }
        }
        let function = functions.pop()?;
        if !seen.insert((function, false)) {
            continue;
        }
        for source in &system.functions[function].sources {
            match source {
                Source::Moved(measure) => {
                    if !of_velocities || measure.kind.is_second() {
                        return Some(if of_velocities {
                            "a dynamic state that depends on accelerations"
                        } else {
                            "a dynamic state that depends on velocities"
                        });
                    }
                }
                Source::Force(_) | Source::Friction(..) => {
                    return Some("a dynamic state that depends on forces");
                }
                Source::StateRate(..) => {
                    return Some("a dynamic state that depends on the rate of another state");
                }
                Source::State(k) => states.push(*k),
                Source::Output((by_state, by_variable)) => {
                    states.extend(by_state.iter().map(|(k, _)| *k));
                    functions.extend(functions_of(system, by_variable));
                }
                Source::Variable(k) => functions.push(system.variables[*k].function),
                Source::Time
                | Source::Mode
                | Source::Measure(..)
                | Source::Constant(_)
                | Source::Sensor(_) => {}
            }
        }
    }
}
