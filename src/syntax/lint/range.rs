use super::context::{Context, known};
use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::grammar::{Bound, Solved};

/// Reports numbers outside of the range of their argument. It is only a warning in statements without effect on the solution, such as
/// GRAPHICS.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for statement in context.statements() {
        let severity = match statement.def.map(|def| def.solved) {
            Some(Solved::NoEffect(_)) => Severity::Warning,
            _ => Severity::Error,
        };
        for (argument, def) in known(statement) {
            if (def.lower, def.upper) == (Bound::Open, Bound::Open) {
                continue;
            }
            for number in argument.numbers() {
                if !def.admits(number.value) {
                    let message = format!(
                        "{} of {} must be {}",
                        def.name,
                        context.title(statement),
                        def.wanted()
                    );
                    found.push(
                        context
                            .complain(severity, Code::OutOfRange, number.span, message)
                            .help(format!("{}: {}", def.name, def.doc)),
                    );
                }
            }
        }
    }
}
