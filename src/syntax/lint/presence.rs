use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::Presence;
use crate::syntax::Statement;

/// Arguments that must stand with others, or one of which must, and do not.
pub(super) fn missing(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for statement in context.statements() {
        let Some(def) = statement.def else { continue };
        let place = statement.head();
        let mut complain = |message: String, help: String| {
            found.push(
                context
                    .error(Code::MissingArgument, place, message)
                    .help(help),
            );
        };
        let title = || context.title(statement);
        for rule in def.presence {
            match rule {
                Presence::OneOf(names) if present(statement, names).is_empty() => {
                    complain(
                        format!("{} needs one of {}", title(), names.join(", ")),
                        "add one of them".to_string(),
                    );
                }
                Presence::Together(names) => {
                    let there = present(statement, names);
                    if !there.is_empty() && there.len() < names.len() {
                        let absent = names.iter().filter(|name| !there.contains(name));
                        let absent: Vec<&str> = absent.copied().collect();
                        complain(
                            format!("{} needs all of {}", title(), names.join(", ")),
                            format!("add {}", absent.join(", ")),
                        );
                    }
                }
                Presence::Requires([first, others @ ..]) if statement.has(first) => {
                    for other in others.iter().filter(|other| !statement.has(other)) {
                        complain(
                            format!("{first} of {} needs {other}", title()),
                            format!("add {other}, or remove {first}"),
                        );
                    }
                }
                Presence::OneOf(_) | Presence::Requires(_) | Presence::Exclusive(_) => {}
            }
        }
    }
}

/// Arguments that cannot stand together.
pub(super) fn conflicting(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let file = context.dataset.source().name();
    for statement in context.statements() {
        for rule in statement.def.map_or(&[][..], |def| def.presence) {
            let (Presence::Exclusive(names) | Presence::OneOf(names)) = rule else {
                continue;
            };
            let there = present(statement, names);
            let [first, second, ..] = there.as_slice() else {
                continue;
            };
            let place = |name| {
                statement
                    .argument(name)
                    .map_or(statement.keyword, |a| a.name)
            };
            let message = format!(
                "{} cannot have both {first} and {second}",
                context.title(statement)
            );
            found.push(
                context
                    .error(Code::ConflictingArguments, place(second), message)
                    .label(file, place(first), "")
                    .help("remove one of them"),
            );
        }
    }
}

fn present<'n>(statement: &Statement, names: &[&'n str]) -> Vec<&'n str> {
    names
        .iter()
        .copied()
        .filter(|name| statement.has(name))
        .collect()
}
