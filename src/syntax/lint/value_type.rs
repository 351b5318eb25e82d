use super::context::{Context, as_id, known};
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::ValueKind;

/// Numbers that are no ids or whole numbers where these are needed.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for statement in context.statements() {
        for (argument, def) in known(statement) {
            let (fits, wanted): (fn(&_) -> bool, _) = match def.kind {
                ValueKind::Reference(_) => (|number| as_id(number).is_some(), "an id"),
                ValueKind::Integer => (|number| number.value.fract() == 0.0, "a whole number"),
                _ => continue,
            };
            for number in argument.numbers() {
                if !fits(number) || number.degrees {
                    let message = format!(
                        "{} of {} takes {wanted}, not {}",
                        def.name,
                        context.title(statement),
                        context.dataset.source().text(number.span)
                    );
                    found.push(
                        context
                            .error(Code::WrongType, number.span, message)
                            .help(format!("{}: {}", def.name, def.doc)),
                    );
                }
            }
        }
    }
}
