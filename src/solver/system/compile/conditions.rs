//! Nonholonomic GCONs, which constrain velocities.

use super::SystemCompiler;
use admire_syntax::diagnostic::{Code, Diagnostic};

impl SystemCompiler<'_> {
    /// Returns whether each constraint equation is nonholonomic. Requires [`SystemCompiler::order`]. Warns about nonholonomic equations,
    /// because statics ignores them.
    pub(super) fn of_velocities(&mut self) -> Vec<bool> {
        let mut out = vec![false; self.equations];
        for condition in &self.conditions {
            out[condition.equation] = self.reads().velocities(condition.function);
            if !condition.active || !out[condition.equation] {
                continue;
            }
            let owner = &condition.name;
            self.diagnostics.push(
                Diagnostic::warning(
                    Code::InactiveInStatics,
                    format!(
                        "{owner} constrains velocities and has no effect in statics, where velocities are zero"
                    ),
                )
                .about(owner.object())
                .help(
                    "in statics, parts can slip where this constraint prevents slip in dynamics",
                ),
            );
        }
        out
    }
}
