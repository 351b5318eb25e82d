use super::context::{Context, known};
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::ArgumentDef;
use crate::units::Dimension;
use crate::{Argument, Statement};

/// Reports the degree suffix on a number that is not an angle, because the suffix divides the number by 57.3.
///
/// Also reports an angle without the suffix that exceeds one turn and is a multiple of five, because it was probably meant in degrees.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for statement in context.statements() {
        for (argument, def) in known(statement) {
            if def.dimension == Dimension::ANGLE {
                looks_like_degrees(context, statement, argument, def, found);
            }
            if def.dimension == Dimension::NONE || def.dimension.angle > 0 {
                continue;
            }
            for number in argument.numbers().iter().filter(|number| number.degrees) {
                let message = format!(
                    "{} of {} is not an angle, but the suffix D divides it by 57.3",
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

/// Reports an angle in radians that was probably meant in degrees. An angle of 90 radians is implausible, but 7 radians may be an
/// accumulated rotation.
fn looks_like_degrees(
    context: &Context<'_>,
    statement: &Statement,
    argument: &Argument,
    def: &ArgumentDef,
    found: &mut Vec<Diagnostic>,
) {
    let suspect = argument.numbers().iter().find(|number| {
        let turns = number.value.abs() / std::f64::consts::TAU;
        !number.degrees && turns > 1.0 && number.value % 5.0 == 0.0
    });
    if let Some(number) = suspect {
        let written = context.dataset.source().text(number.span);
        let message = format!(
            "{} of {} is {written} radians, which looks like degrees",
            def.name,
            context.title(statement)
        );
        found.push(
            context
                .warning(Code::WrongDimension, number.span, message)
                .help(format!("degrees have the suffix D: {written}D")),
        );
    }
}
