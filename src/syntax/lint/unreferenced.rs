use std::collections::HashSet;

use super::context::Context;
use crate::Value;
use crate::diagnostic::{Code, Diagnostic};

/// Reports data objects to which nothing refers. Unused markers are normal in decks of ADAMS/View; `admire summary` counts them.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let mut used = HashSet::new();
    let mut user = false;
    for statement in context.statements() {
        for reference in Context::references(statement) {
            used.insert((reference.space, reference.id));
        }
        user |= statement
            .arguments
            .iter()
            .any(|argument| matches!(argument.value, Value::User(_)));
    }
    // A user subroutine may read any object by its id.
    if user {
        return;
    }
    for statement in context.statements() {
        let Some(kind @ ("SPLINE" | "ARRAY" | "MATRIX" | "STRING" | "CURVE")) = statement.kind()
        else {
            continue;
        };
        let (Some(space), Some(id)) = (statement.def.and_then(|def| def.id), statement.number())
        else {
            continue;
        };
        if !used.contains(&(space, id)) {
            let message = format!("nothing uses {}", context.title(statement));
            found.push(
                context
                    .note(Code::Unreferenced, statement.head(), message)
                    .help(format!("this {kind} has no effect")),
            );
        }
    }
}
