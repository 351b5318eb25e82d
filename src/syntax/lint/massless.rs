use std::collections::HashSet;

use super::context::Context;
use crate::diagnostic::{Code, Diagnostic, Severity};

/// Reports parts that have no mass and are held by no constraint.
///
/// If nothing acts on such a part, it is free, and a warning is given. If only forces act on it, its acceleration is undefined; this is
/// only a note, because statics does not need accelerations.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let (mut constrained, mut loaded) = (HashSet::new(), HashSet::new());
    for statement in context.statements() {
        let held = match statement.kind() {
            Some("MARKER" | "GRAPHICS" | "REQUEST" | "MREQUEST" | "PART" | "ARRAY") => continue,
            Some(
                "SFORCE" | "VFORCE" | "VTORQUE" | "GFORCE" | "NFORCE" | "BUSHING" | "BEAM"
                | "FIELD" | "SPRINGDAMPER" | "CONTACT" | "VARIABLE" | "SENSOR" | "DIFF" | "TIRE",
            ) => &mut loaded,
            _ => &mut constrained,
        };
        for reference in Context::references(statement) {
            match reference.space {
                "marker" => {
                    let marker = context.find("marker", reference.id);
                    held.extend(marker.and_then(|marker| context.body(marker)));
                }
                "part" => {
                    held.insert(("part", reference.id));
                }
                _ => {}
            }
        }
    }
    for part in context.of_kind("PART") {
        let Some(id) = part.number() else { continue };
        let has_mass = part.first("MASS").is_some_and(|mass| mass > 0.0);
        if has_mass || part.has("GROUND") || constrained.contains(&("part", id)) {
            continue;
        }
        let title = context.title(part);
        let (severity, message) = if loaded.contains(&("part", id)) {
            (
                Severity::Note,
                format!(
                    "{title} has no mass and is held only by forces: its acceleration is undefined"
                ),
            )
        } else {
            (
                Severity::Warning,
                format!("{title} has no mass and is not attached to anything"),
            )
        };
        found.push(
            context
                .complain(severity, Code::FreeWithoutMass, part.head(), message)
                .help("give the part a mass with CM and IP, attach it with a joint, or remove it"),
        );
    }
}
