use std::collections::HashMap;

use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};
use crate::{Number, Statement};

/// The degree of freedom that a MOTION drives: a joint id or a pair of marker ids, and the axis.
type Freedom = (Option<u32>, Option<(u32, u32)>, &'static str);

/// Reports motions that drive a degree of freedom which their joint does not have, and second motions for the same degree of freedom.
///
/// Only translational, revolute and cylindrical joints can be driven (`state_motion`); screw joints are accepted as well.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let file = context.dataset.source().name();
    let mut driven: HashMap<Freedom, &Statement> = HashMap::new();
    for motion in context.of_kind("MOTION") {
        let title = context.title(motion);
        let id = |name| motion.numbers(name).first().and_then(Number::as_id);
        let asked = [
            "TRANSLATIONAL",
            "ROTATIONAL",
            "X",
            "Y",
            "Z",
            "B1",
            "B2",
            "B3",
        ]
        .into_iter()
        .find(|axis| motion.has(axis));
        let mut axis = asked;
        if let Some(joint) = id("JOINT").and_then(|id| context.find("joint", id)) {
            let (kind, freedoms) = freedoms_of(joint);
            let fits = match asked {
                Some(asked @ ("TRANSLATIONAL" | "ROTATIONAL")) => freedoms.contains(&asked),
                _ => !freedoms.is_empty(),
            };
            if !fits && !kind.is_empty() {
                let message = match asked {
                    Some(asked) if !freedoms.is_empty() => {
                        format!("{title} is {asked}, but {} is {kind}", context.title(joint))
                    }
                    _ => format!(
                        "{title} drives {}, which is {kind} and cannot be driven",
                        context.title(joint)
                    ),
                };
                found.push(
                    context
                        .error(Code::WrongMotion, motion.head(), message)
                        .label(file, joint.head(), "the joint")
                        .help("a MOTION drives a REVOLUTE, TRANSLATIONAL or CYLINDRICAL joint, or a pair of markers"),
                );
                continue;
            }
            axis = asked.or(freedoms.first().copied());
        }
        let Some(axis) = axis else { continue };
        let pair = id("I").zip(id("J"));
        if id("JOINT").is_none() && pair.is_none() {
            continue;
        }
        let freedom = (id("JOINT"), pair, axis);
        if let Some(first) = driven.get(&freedom) {
            let message = format!(
                "{title} and {} drive the same degree of freedom: one of them is redundant, or they contradict each other",
                context.title(first)
            );
            found.push(
                context
                    .warning(Code::WrongMotion, motion.head(), message)
                    .label(file, first.head(), "the other one")
                    .help("remove one of them, or deactivate one in the command file"),
            );
        } else {
            driven.insert(freedom, motion);
        }
    }
}

/// Returns the type of a joint (empty if unknown) and the degrees of freedom that a MOTION can drive in it.
fn freedoms_of(joint: &Statement) -> (&'static str, &'static [&'static str]) {
    const DRIVEN: [(&str, &[&str]); 4] = [
        ("REVOLUTE", &["ROTATIONAL"]),
        ("TRANSLATIONAL", &["TRANSLATIONAL"]),
        ("CYLINDRICAL", &["TRANSLATIONAL", "ROTATIONAL"]),
        ("SCREW", &["TRANSLATIONAL", "ROTATIONAL"]),
    ];
    const NOT_DRIVEN: [&str; 7] = [
        "FIXED",
        "SPHERICAL",
        "PLANAR",
        "HOOKE",
        "UNIVERSAL",
        "CONVEL",
        "RACKPIN",
    ];
    let driven = DRIVEN.into_iter().find(|(kind, _)| joint.has(kind));
    let other = NOT_DRIVEN.into_iter().find(|kind| joint.has(kind));
    driven.unwrap_or((other.unwrap_or(""), &[]))
}
