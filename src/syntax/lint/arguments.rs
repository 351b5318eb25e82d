use super::context::{Context, known};
use crate::diagnostic::{Code, Diagnostic};

/// Reports arguments that are written twice in a statement; only the later occurrence counts. Y of a SPLINE with several curves may be
/// repeated.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let file = context.dataset.source().name();
    for statement in context.statements() {
        for (at, (argument, def)) in known(statement).enumerate() {
            if statement.def.is_some_and(|own| own.adds_rows(def.name)) {
                continue;
            }
            let before = known(statement)
                .take(at)
                .find(|(_, other)| other.name == def.name);
            if let Some((first, _)) = before {
                let message = format!(
                    "{} has {} twice; the later one is used",
                    context.title(statement),
                    def.name
                );
                found.push(
                    context
                        .warning(Code::RepeatedArgument, argument.name, message)
                        .label(file, first.name, "first given here")
                        .help("remove one of them"),
                );
            }
        }
    }
}
