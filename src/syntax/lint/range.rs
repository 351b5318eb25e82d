use super::context::{Context, known};
use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::grammar::{ArgumentDef, Bound, Solved};

/// Numbers outside of the range of their argument: a warning in what has no effect on the solution, such as a picture's radius.
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
                if !inside(def, number.value) {
                    let message = format!(
                        "{} of {} must be {}",
                        def.name,
                        context.title(statement),
                        wanted(def)
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

fn inside(def: &ArgumentDef, value: f64) -> bool {
    let above = match def.lower {
        Bound::Open => true,
        Bound::Inclusive(bound) => value >= bound,
        Bound::Exclusive(bound) => value > bound,
    };
    let below = match def.upper {
        Bound::Open => true,
        Bound::Inclusive(bound) => value <= bound,
        Bound::Exclusive(bound) => value < bound,
    };
    above && below
}

fn wanted(def: &ArgumentDef) -> String {
    let lower = match def.lower {
        Bound::Open => None,
        Bound::Inclusive(bound) => Some(format!("{bound} or more")),
        Bound::Exclusive(bound) => Some(format!("more than {bound}")),
    };
    let upper = match def.upper {
        Bound::Open => None,
        Bound::Inclusive(bound) => Some(format!("{bound} or less")),
        Bound::Exclusive(bound) => Some(format!("less than {bound}")),
    };
    [lower, upper]
        .into_iter()
        .flatten()
        .collect::<Vec<_>>()
        .join(" and ")
}
