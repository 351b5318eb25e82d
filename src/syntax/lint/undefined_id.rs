use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};

/// Ids in arguments and functions that no statement defines.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for statement in context.statements() {
        for reference in Context::references(statement) {
            if context.find(reference.space, reference.id).is_none() {
                let object = format!("{}/{}", reference.space.to_uppercase(), reference.id);
                let message = format!(
                    "{} names {object}, which is not in this dataset",
                    context.title(statement)
                );
                found.push(
                    context
                        .error(Code::UndefinedId, reference.span, message)
                        .help(format!("add {object}, or name one that is there")),
                );
            }
        }
    }
}
