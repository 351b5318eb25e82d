use super::context::Context;
use crate::diagnostic::Diagnostic;
use crate::floating_faults;

/// Reports floating markers where a fixed one is required, and fixed markers where a floating one is required.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let dataset = context.dataset;
    for statement in context.statements() {
        found.extend(floating_faults(statement, dataset.source(), dataset));
    }
}
