use super::context::{Context, known};
use crate::diagnostic::{Code, Diagnostic};
use crate::syntax::Value;

/// Values that are more or fewer than the grammar allows.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for statement in context.statements() {
        for (argument, def) in known(statement) {
            let given = match &argument.value {
                Value::Numbers(numbers) => numbers.len(),
                Value::Words(words) => words.len(),
                Value::Texts(texts) => texts.len(),
                Value::Flag | Value::Function(_) | Value::User(_) | Value::Malformed(_) => continue,
            };
            let (min, max) = (def.count.min, def.count.max);
            if given >= min && max.is_none_or(|max| given <= max) {
                continue;
            }
            let wanted = match max {
                Some(max) if max == min => format!("{min}"),
                Some(max) => format!("{min} to {max}"),
                None => format!("at least {min}"),
            };
            let message = format!(
                "{} of {} takes {wanted} values, not {given}",
                def.name,
                context.title(statement)
            );
            found.push(
                context
                    .error(Code::WrongCount, argument.value_span(), message)
                    .help(format!("{}: {}", def.name, def.doc)),
            );
        }
    }
}
