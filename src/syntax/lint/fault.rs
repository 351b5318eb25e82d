use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};

/// Ids in arguments and functions that no statement defines.
pub(super) fn undefined_id(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    of_code(Code::UndefinedId, context, found);
}

/// Values that are more or fewer than the grammar allows.
pub(super) fn count(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    of_code(Code::WrongCount, context, found);
}

/// Numbers that are no ids or whole numbers where these are needed.
pub(super) fn value_type(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    of_code(Code::WrongType, context, found);
}

/// Arguments that must be there, alone or with others, and are not.
pub(super) fn missing(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    of_code(Code::MissingArgument, context, found);
}

/// Arguments that cannot stand together.
pub(super) fn conflicting(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    of_code(Code::ConflictingArguments, context, found);
}

fn of_code(code: Code, context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let source = context.dataset.source();
    let own = context.faults().iter().filter(|fault| fault.code() == code);
    found.extend(own.map(|fault| fault.diagnostic(source, "this dataset")));
}
