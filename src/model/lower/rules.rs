//! Rules on a statement that come from the grammar alone: what is required, how many values, what ids refer to.

use super::ids::Ids;
use super::reader::as_id;
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::{Solved, StatementDef, ValueKind, nearest};
use crate::syntax::{Argument, Number, Statement, Value};
use crate::text::Source;

/// Complaints about one statement. `whole` says that it must stand by itself: a command redefines only what it gives.
pub(super) fn check(
    source: &Source,
    statement: &Statement,
    def: &'static StatementDef,
    ids: &Ids,
    whole: bool,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let called = || match statement.number() {
        Some(id) => format!("{}/{id}", def.name),
        None => def.name.to_string(),
    };
    let missing = def
        .arguments
        .iter()
        .filter(|argument| whole && argument.required && !statement.has(argument.name));
    for argument in missing {
        diagnostics.push(
            Diagnostic::error(
                Code::MissingArgument,
                format!("{} needs {}: {}", called(), argument.name, argument.doc),
            )
            .label(source.name(), statement.keyword, ""),
        );
    }
    for argument in &statement.arguments {
        counts(source, argument, diagnostics);
        references(source, def, argument, ids, diagnostics);
    }
}

/// How many values an argument has.
fn counts(source: &Source, argument: &Argument, diagnostics: &mut Vec<Diagnostic>) {
    let Some(def) = argument.def else {
        return;
    };
    let many = match &argument.value {
        Value::Numbers(numbers) => numbers.len(),
        Value::Words(words) => words.len(),
        _ => return,
    };
    let max = def.count.max.unwrap_or(usize::MAX);
    if def.kind == ValueKind::Flag || (def.count.min..=max).contains(&many) {
        return;
    }
    let wanted = match (def.count.min, def.count.max) {
        (min, Some(max)) if min == max => format!("{min}"),
        (min, Some(max)) => format!("{min} to {max}"),
        (min, None) => format!("at least {min}"),
    };
    diagnostics.push(
        Diagnostic::error(
            Code::WrongCount,
            format!("{} takes {wanted} values, not {many}", def.name),
        )
        .label(source.name(), argument.value_span(), ""),
    );
}

/// What ids refer to, in arguments and in functions.
fn references(
    source: &Source,
    def: &'static StatementDef,
    argument: &Argument,
    ids: &Ids,
    diagnostics: &mut Vec<Diagnostic>,
) {
    match (&argument.value, argument.def.map(|def| def.kind)) {
        (Value::Numbers(numbers), Some(ValueKind::Reference(space))) => {
            for number in numbers {
                if number.value == 0.0 && needs_object(def, argument) {
                    diagnostics.push(
                        Diagnostic::error(Code::WrongType, "0 is not an id")
                            .label(source.name(), number.span, "")
                            .help(format!(
                                "{} must name a {}",
                                shown(argument),
                                kind_of(space)
                            )),
                    );
                }
                reference(source, def, space, *number, ids, diagnostics);
            }
        }
        (Value::Function(expression), _) => {
            for (space, literal) in expression.references() {
                reference(
                    source,
                    def,
                    space,
                    expression.literals[literal],
                    ids,
                    diagnostics,
                );
            }
        }
        _ => {}
    }
}

/// True if an argument cannot do with 0, which stands for ground or for nothing in others (RM, and J of a REQUEST).
fn needs_object(def: &'static StatementDef, argument: &Argument) -> bool {
    let acts = !matches!(def.solved, Solved::NoEffect(_)) && def.name != "REQUEST";
    acts && argument.def.is_some_and(|own| {
        own.required
            || matches!(
                own.name,
                "I" | "J" | "IFLOAT" | "JFLOAT" | "JOINT" | "JOINTS"
            )
    })
}

fn shown(argument: &Argument) -> &'static str {
    argument.kind().unwrap_or("it")
}

/// The keyword of the statements of an id space.
fn kind_of(space: &str) -> String {
    space.rsplit('.').next().unwrap_or(space).to_uppercase()
}

fn reference(
    source: &Source,
    def: &'static StatementDef,
    space: &'static str,
    number: Number,
    ids: &Ids,
    diagnostics: &mut Vec<Diagnostic>,
) {
    if number.value == 0.0 {
        return;
    }
    let Some(id) = as_id(number.value) else {
        diagnostics.push(
            Diagnostic::error(
                Code::WrongType,
                format!("{} is not an id", source.text(number.span)),
            )
            .label(source.name(), number.span, ""),
        );
        return;
    };
    if ids.defines(space, id) {
        return;
    }
    let kind = space
        .rsplit('.')
        .next()
        .unwrap_or(space)
        .to_ascii_uppercase();
    let message = format!("{kind}/{id} is not defined");
    let mut diagnostic = match def.solved {
        Solved::Native(_) => Diagnostic::error(Code::UndefinedId, message),
        Solved::NoEffect(_) | Solved::External(_) => {
            Diagnostic::warning(Code::UndefinedId, message)
        }
    }
    .label(source.name(), number.span, "");
    // Only the first few complaints search for what could be meant: a deck that lost its parts complains in every line.
    if diagnostics.len() < 50 {
        let all: Vec<String> = ids.all(space).iter().map(u32::to_string).collect();
        if let Some(near) = nearest(&id.to_string(), all.iter().map(String::as_str)) {
            diagnostic = diagnostic.help(format!("did you mean {kind}/{near}?"));
        }
    }
    diagnostics.push(diagnostic);
}
