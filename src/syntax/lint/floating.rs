use super::context::{Context, known};
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::ValueKind;

/// Floating markers where a fixed one is needed, and fixed ones where the solver must move it.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for statement in context.statements() {
        // A request may measure floating markers; graphics and markers themselves have their own uses of them.
        if matches!(
            statement.kind(),
            Some("REQUEST" | "GRAPHICS" | "MARKER" | "TIRE" | "FEMDATA")
        ) {
            continue;
        }
        for (argument, def) in known(statement) {
            if def.kind != ValueKind::Reference("marker") {
                continue;
            }
            let needed = matches!(def.name, "JFLOAT" | "IFLOAT");
            for number in argument.numbers() {
                let Some(marker) = number.as_id().and_then(|id| context.find("marker", id)) else {
                    continue;
                };
                if marker.has("FLOATING") == needed {
                    continue;
                }
                let (is, should, help) = if needed {
                    (
                        "fixed on its part",
                        "FLOATING: the solver moves it",
                        "add FLOATING to a marker that nothing else uses, and name that",
                    )
                } else {
                    (
                        "FLOATING and has no place",
                        "fixed on its part",
                        "name a marker that has a place, or remove FLOATING",
                    )
                };
                let message = format!(
                    "{} of {} is {}, which is {is}; it must be {should}",
                    def.name,
                    context.title(statement),
                    context.title(marker)
                );
                found.push(
                    context
                        .error(Code::FloatingMarker, number.span, message)
                        .label(
                            context.dataset.source().name(),
                            marker.head(),
                            "this marker",
                        )
                        .help(help),
                );
            }
        }
    }
}
