use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};

/// Reports ids in arguments and functions that no statement defines.
pub(super) fn undefined_id(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    of_code(Code::UndefinedId, context, found);
}

/// Reports arguments with more or fewer values than the grammar allows.
pub(super) fn count(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    of_code(Code::WrongCount, context, found);
}

/// Reports numbers that should be an id or an integer and are not.
pub(super) fn value_type(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    of_code(Code::WrongType, context, found);
}

/// Reports missing arguments: arguments that the statement requires, and arguments that other arguments require.
pub(super) fn missing(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    of_code(Code::MissingArgument, context, found);
}

/// Reports arguments that exclude each other.
pub(super) fn conflicting(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    of_code(Code::ConflictingArguments, context, found);
}

fn of_code(code: Code, context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let source = context.dataset.source();
    let own = context.faults().iter().filter(|fault| fault.code() == code);
    found.extend(own.map(|fault| fault.diagnostic(source, "this dataset")));
}
