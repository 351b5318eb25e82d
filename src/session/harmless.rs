//! Commands that have no effect on the results of a run, and the assignment of diagnostics to commands.

use admire_syntax::Statement;
use admire_syntax::diagnostic::Diagnostic;

/// Returns true for commands that only print, or that have no effect in this program.
pub(super) fn is_output_only(kind: Option<&str>) -> bool {
    matches!(
        kind,
        Some(
            "INFO"
                | "SHOW"
                | "HELP"
                | "MENU"
                | "ENVIRONMENT"
                | "DEBUG"
                | "LSOLVER"
                | "TIME"
                | "LIST"
                | "NOLIST"
        )
    )
}

/// Returns true if the location of a diagnostic lies in a command.
pub(super) fn is_in(command: &Statement, complaint: &Diagnostic) -> bool {
    (command.span.start()..=command.span.end()).contains(&place_in_file(complaint))
}

/// Returns the byte offset at which the location of a diagnostic begins, or 0 if it has no location.
pub(super) fn place_in_file(diagnostic: &Diagnostic) -> usize {
    diagnostic
        .labels
        .first()
        .map_or(0, |label| label.span.start())
}
