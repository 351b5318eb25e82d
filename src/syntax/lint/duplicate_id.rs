use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};

/// Reports pairs of statements in one id space that have the same id.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let file = context.dataset.source().name();
    for statement in context.statements() {
        let (Some(def), Some((id, span))) = (statement.def, statement.id) else {
            continue;
        };
        let Some(first) = def.id.and_then(|space| context.find(space, id)) else {
            continue;
        };
        if first.keyword != statement.keyword {
            let message = format!("{}/{id} is defined twice", def.name);
            found.push(
                context
                    .error(Code::DuplicateId, span, message)
                    .label(file, first.head(), "first defined here")
                    .help("give one of them a free id"),
            );
        }
    }
}
