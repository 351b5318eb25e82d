use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};

/// Ids in arguments and functions that no statement defines.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for statement in context.statements() {
        for reference in Context::references(statement) {
            if context.find(reference.space, reference.id).is_none() {
                let message = format!(
                    "{} names {}/{}, which is not in this dataset",
                    context.title(statement),
                    reference.space.to_uppercase(),
                    reference.id
                );
                found.push(context.error(Code::UndefinedId, reference.span, message));
            }
        }
    }
}
