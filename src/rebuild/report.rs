use std::fmt::Write as _;

use admire_solver::mechanics::Vec3;
use admire_syntax::units::{Dimension, short_unit};

use super::deck::Deck;
use super::law::AxisLaw;
use super::mechanism::{Mechanism, Role};
use super::record::Record;
use super::repeat_states::Repeat;

/// Returns the report of a rebuild as Markdown: the findings, the agreement with the results, and what the results do not determine.
pub(crate) fn report(
    record: &Record,
    mechanism: &Mechanism,
    deck: &Deck,
    repeat: &Repeat,
) -> String {
    let units = &record.units;
    let length = units.length.word;
    let mut text = "# Rebuilt deck\n\n## Agreement with the results\n\n".to_string();
    let _ = writeln!(
        text,
        "| results | states | largest position error of a part ({length}) | largest rotation error of a part (rad) |\n|---|---|---|---|"
    );
    for run in &record.runs {
        let turned = repeat.turns_rad[run.states.clone()]
            .iter()
            .flatten()
            .copied()
            .fold(0.0, f64::max);
        let place = repeat.largest(run.states.clone()).map_or_else(
            || "a state has no equilibrium".to_string(),
            |place| format!("{place:.2e}"),
        );
        let _ = writeln!(
            text,
            "| {} | {} | {place} | {turned:.2e} |",
            run.name,
            run.states.len()
        );
    }
    let _ = writeln!(
        text,
        "\nPart with the largest error: {}. The moments on all parts are balanced to a lever arm of {:.1e} {length}.",
        record.bodies[repeat.worst].name, mechanism.lever_left
    );
    if let Some(error) = &repeat.error {
        let _ = writeln!(text, "Message of the solver: {error}");
    }
    parts(record, mechanism, deck, &mut text);
    connections(record, mechanism, deck, &mut text);
    laws(record, mechanism, deck, &mut text);
    unknown(record, mechanism, &mut text);
    text
}

fn vector(v: &Vec3) -> String {
    format!("{:.6}, {:.6}, {:.6}", v.x, v.y, v.z)
}

fn certain(open: f64) -> &'static str {
    if open < 1e-3 {
        "determined"
    } else {
        "partly determined"
    }
}

fn parts(record: &Record, mechanism: &Mechanism, deck: &Deck, text: &mut String) {
    let units = &record.units;
    let _ = writeln!(
        text,
        "\n## Parts\n\n| part | id | mass ({}) | centre of mass on the part ({}) | the centre of mass is |\n|---|---|---|---|---|",
        units.mass.word, units.length.word
    );
    for (k, body) in record.bodies.iter().enumerate().skip(1) {
        let mass = &mechanism.bodies[k];
        let (value, centre) = if mass.mass > 0.0 {
            (format!("{:.6}", mass.mass), vector(&mass.centre))
        } else {
            ("not determined".to_string(), "-".to_string())
        };
        let state = if mass.mass > 0.0 {
            certain(mass.open)
        } else {
            "-"
        };
        let _ = writeln!(
            text,
            "| {} | {} | {value} | {centre} | {state} |",
            body.name, deck.parts[k]
        );
    }
}

fn connections(record: &Record, mechanism: &Mechanism, deck: &Deck, text: &mut String) {
    let _ = writeln!(
        text,
        "\n## Connections\n\nPoints are given at the design position, in ground axes ({}).\n\n\
         | element | address in the deck | kind | I part | J part | point | the point is |\n|---|---|---|---|---|---|---|",
        record.units.length.word
    );
    for (k, member) in mechanism.members.iter().enumerate() {
        let connection = member.connection;
        let (kind, point) = match &member.role {
            Role::Joint(joint) => (joint.kind, joint.i.p),
            Role::Motion { i, .. } => ("prescribed motion", i.p),
            Role::Bushing { i, law, .. } if law.is_linear() => ("bushing", i.p),
            Role::Bushing { i, .. } => ("bushing with curves", i.p),
            Role::Spring(spring) => ("spring", spring.i),
            Role::Load(point) => ("given load", *point),
            Role::Carried => ("carried by a FIXED joint", Vec3::zeros()),
        };
        let place = record.bodies[connection.i].design.point(&point);
        let _ = writeln!(
            text,
            "| {} | {} | {kind} | {} | {} | {} | {} |",
            record.elements[connection.element].name,
            deck.addresses.get(k).map_or("-", |(_, address)| address),
            record.bodies[connection.i].name,
            record.bodies[connection.j].name,
            vector(&place),
            certain(member.open),
        );
    }
}

fn laws(record: &Record, mechanism: &Mechanism, deck: &Deck, text: &mut String) {
    let units = &record.units;
    let per = |dimension: Dimension| short_unit(&units.name(dimension));
    let _ = writeln!(
        text,
        "\n## Force laws\n\nStiffness in {} and {}; deflections in {} and rad, in J axes.\n\n\
         | element | axis | law | preload | stiffness | deflection from | to |\n|---|---|---|---|---|---|---|",
        per(Dimension::new(1, 0, -1, 0, 0)),
        per(Dimension::TORQUE),
        units.length.word
    );
    for (k, member) in mechanism.members.iter().enumerate() {
        let address = deck
            .addresses
            .get(k)
            .map_or("-", |(_, address)| address.as_str());
        let mut row = |axis: &str, law: &AxisLaw, (from, to): (f64, f64)| {
            let (kind, preload, stiffness) = match law {
                AxisLaw::Linear { preload, stiffness } => {
                    ("linear", format!("{preload:.6}"), format!("{stiffness:.6}"))
                }
                AxisLaw::Curve(points) => (
                    "curve",
                    "in the curve".to_string(),
                    format!("{} points", points.len()),
                ),
                AxisLaw::Odd { preload, points } => (
                    "radial curve",
                    format!("{preload:.4}"),
                    format!("{} points", points.len()),
                ),
                AxisLaw::Unseen(preload) => {
                    ("not moved", format!("{preload:.6}"), "default".to_string())
                }
            };
            let name = &record.elements[member.connection.element].name;
            let _ = writeln!(
                text,
                "| {name} ({address}) | {axis} | {kind} | {preload} | {stiffness} | {from:.6} | {to:.6} |"
            );
        };
        let range = |values: &[Vec3], axis: usize| {
            let each = || values.iter().map(|v| v[axis]);
            (
                each().fold(f64::INFINITY, f64::min),
                each().fold(f64::NEG_INFINITY, f64::max),
            )
        };
        match &member.role {
            Role::Bushing { law, motion, .. } => {
                for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
                    row(
                        &format!("f{letter}"),
                        &law.force[axis],
                        range(&motion.deflection, axis),
                    );
                }
                for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
                    row(
                        &format!("t{letter}"),
                        &law.torque[axis],
                        range(&motion.angles, axis),
                    );
                }
            }
            Role::Spring(spring) => row("length", &spring.law, spring.visited),
            _ => {}
        }
    }
}

fn unknown(record: &Record, mechanism: &Mechanism, text: &mut String) {
    *text += "\n## What the results do not determine\n\n\
        - Moments of inertia: all parts have the same default value.\n\
        - Damping: the deck has none.\n\
        - Force laws beyond the range of deflections (last two columns of the table of force laws): curves continue linearly.\n";
    if mechanism.down == Vec3::zeros() {
        *text += "- Gravity: the results show no weight of any part, so the deck has no gravity.\n";
    } else {
        *text += "- Gravity: masses are weights divided by standard gravity, 9.80665 m/s^2.\n";
    }
    if !record.has_design {
        *text += "- The design position: the file does not contain it, and the first state is used instead.\n";
    }
    let element = |k: &usize| record.elements[*k].name.as_str();
    let body = |k: &usize| record.bodies[*k].name.as_str();
    let mut list = |what: &str, names: Vec<&str>| {
        if !names.is_empty() {
            let _ = writeln!(text, "- {what}: {}.", names.join(", "));
        }
    };
    list(
        "Elements without any force in these states, left out",
        mechanism.idle.iter().map(element).collect(),
    );
    list(
        "Elements whose parts are not found, left out",
        mechanism.lost.iter().map(element).collect(),
    );
    list(
        "Parts that move without any force in the file",
        mechanism.bare.iter().map(body).collect(),
    );
    let held: Vec<&str> = mechanism.rigid.iter().map(|(a, _)| body(a)).collect();
    list(
        "Parts that never move relative to another part and are fixed to it",
        held,
    );
    let open = mechanism
        .members
        .iter()
        .filter(|member| member.open >= 1e-3);
    list(
        "Points that the states determine only in part",
        open.map(|m| element(&m.connection.element)).collect(),
    );
}
