use super::context::Context;
use crate::Argument;
use crate::diagnostic::{Code, Diagnostic, Severity};

/// Reports constraints and forces whose two markers are on the same body.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for statement in context.statements() {
        let second = match statement.kind() {
            Some("JOINT" | "JPRIM" | "MOTION") => "J",
            Some(_) if statement.def.is_some_and(|def| !def.laws.is_empty()) => "J",
            // For an action-only force, J only gives the direction and may be on the same body as I: a follower force.
            Some("SFORCE") if !statement.has("ACTIONONLY") => "J",
            Some("GFORCE" | "VFORCE" | "VTORQUE" | "PTCV") => "JFLOAT",
            _ => continue,
        };
        let (Some(i), Some(j)) = (
            context.marker(statement, "I"),
            context.marker(statement, second),
        ) else {
            continue;
        };
        let (Some(body), true) = (context.body(i), context.body(i) == context.body(j)) else {
            continue;
        };
        let constraint = matches!(
            statement.kind(),
            Some("JOINT" | "JPRIM" | "MOTION" | "PTCV")
        );
        let (severity, consequence) = if constraint {
            (
                Severity::Error,
                "it constrains nothing and its equations are singular",
            )
        } else {
            (Severity::Warning, "it has no effect")
        };
        let place = statement
            .argument(second)
            .map_or(statement.keyword, Argument::value_span);
        let message = format!(
            "both markers of {} are on {}/{}: {consequence}",
            context.title(statement),
            body.0.to_uppercase(),
            body.1
        );
        found.push(
            context
                .complain(severity, Code::MarkersOnOnePart, place, message)
                .help("one of the two markers must be on the other part"),
        );
    }
}
