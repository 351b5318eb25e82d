use super::context::Context;
use crate::diagnostic::Diagnostic;
use crate::floating_faults;

/// Floating markers where a fixed one is needed, and fixed ones where the solver must move it.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let dataset = context.dataset;
    for statement in context.statements() {
        found.extend(floating_faults(statement, dataset.source(), dataset));
    }
}
