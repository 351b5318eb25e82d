//! Commands and complaints that change nothing in a static run.

use admire_syntax::Statement;
use admire_syntax::diagnostic::Diagnostic;

/// True for commands that only print, or concern other analyses: they change nothing here.
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

/// True where a complaint lies in a command.
pub(super) fn is_in(command: &Statement, complaint: &Diagnostic) -> bool {
    (command.span.start()..=command.span.end()).contains(&place_in_file(complaint))
}

/// Where a complaint begins, in bytes.
pub(super) fn place_in_file(diagnostic: &Diagnostic) -> usize {
    diagnostic
        .labels
        .first()
        .map_or(0, |label| label.span.start())
}
