//! Checks for floating markers where a fixed one is required, and for fixed markers where a floating one is required.

use super::{Dataset, Statement};
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::ValueKind;
use crate::text::Source;

/// Returns errors about fixed or floating markers in a statement; `source` is the file of the statement, and `dataset` defines the markers.
pub fn floating_faults(
    statement: &Statement,
    source: &Source,
    dataset: &Dataset,
) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    // Requests may measure floating markers. Graphics, tyres and markers use floating markers in special ways.
    if matches!(
        statement.kind(),
        Some("REQUEST" | "GRAPHICS" | "MARKER" | "TIRE" | "FEMDATA")
    ) {
        return found;
    }
    let arguments = statement.arguments.iter();
    for (argument, def) in arguments.filter_map(|argument| Some((argument, argument.def?))) {
        if def.kind != ValueKind::Reference("marker") {
            continue;
        }
        let needed = matches!(def.name, "JFLOAT" | "IFLOAT");
        for number in argument.numbers() {
            let id = number.as_id();
            let Some(marker) = id.and_then(|id| dataset.statement("MARKER", Some(id))) else {
                continue;
            };
            if marker.has("FLOATING") == needed {
                continue;
            }
            let (is, should, help) = if needed {
                (
                    "fixed on its part",
                    "FLOATING, because the solver moves it",
                    "use a marker with FLOATING that nothing else refers to",
                )
            } else {
                (
                    "FLOATING and has no fixed position",
                    "fixed on its part",
                    "use a marker with a fixed position, or remove FLOATING",
                )
            };
            let message = format!(
                "{} of {} is {}, which is {is}; it must be {should}",
                def.name,
                statement.title(source),
                marker.title(dataset.source())
            );
            found.push(
                Diagnostic::error(Code::FloatingMarker, message)
                    .label(source.name(), number.span, "")
                    .label(dataset.source().name(), marker.head(), "this marker")
                    .help(help),
            );
        }
    }
    found
}
