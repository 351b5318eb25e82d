use super::context::{Context, known};
use crate::diagnostic::{Code, Diagnostic};
use crate::units::Dimension;

/// A degree suffix on a number that is no angle: it divides the number by 57.3.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for statement in context.statements() {
        for (argument, def) in known(statement) {
            if def.dimension == Dimension::NONE || def.dimension.angle > 0 {
                continue;
            }
            for number in argument.numbers().iter().filter(|number| number.degrees) {
                let message = format!(
                    "{} of {} is no angle, and the suffix D divides it by 57.3",
                    def.name,
                    context.title(statement)
                );
                let help = if def.dimension.angle < 0 {
                    "stiffness per degree times 57.29578 is stiffness per radian"
                } else {
                    "remove the D"
                };
                found.push(
                    context
                        .warning(Code::WrongDimension, number.span, message)
                        .help(help),
                );
            }
        }
    }
}
