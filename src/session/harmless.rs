//! Commands and diagnostics without effect on a static run.

use admire_syntax::Statement;
use admire_syntax::diagnostic::Diagnostic;

/// Returns true for commands that only print or concern other analyses.
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

/// Returns true if a diagnostic lies in a command.
pub(super) fn is_in(command: &Statement, complaint: &Diagnostic) -> bool {
    (command.span.start()..=command.span.end()).contains(&place_in_file(complaint))
}

/// Returns the start offset of a diagnostic in bytes.
pub(super) fn place_in_file(diagnostic: &Diagnostic) -> usize {
    diagnostic
        .labels
        .first()
        .map_or(0, |label| label.span.start())
}
