//! Conversion of diagnostics and edits to protocol types.

use lsp_types::{
    DiagnosticRelatedInformation, DiagnosticSeverity, DiagnosticTag, Location, NumberOrString,
    TextEdit, Uri,
};

use super::position::range;
use super::workspace::{File, uri_of};
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::pieces::Pieces;
use admire_syntax::text::{Edit, Span};

/// Largest number of diagnostics published for one file; editors do not show more.
const MOST_SHOWN: usize = 1000;

/// Returns the diagnostics of a file that are to be published.
pub(super) fn shown(file: &File) -> Vec<lsp_types::Diagnostic> {
    let wanted = |found: &Diagnostic| file.settings.shows(found);
    let (all, dropped) = file.document.complaints_where(wanted, MOST_SHOWN - 1);
    let pieces = file.document.pieces();
    let mut shown: Vec<_> = all
        .iter()
        .map(|found| diagnostic(&found.diagnostic, pieces, &file.uri))
        .collect();
    if dropped > 0 {
        let more = Diagnostic::note(
            Code::LimitExceeded,
            format!("messages that are not shown here: {dropped}; `admire check` lists all"),
        );
        let more = more.label(file.document.name(), Span::at(0), "");
        shown.push(diagnostic(&more, pieces, &file.uri));
    }
    shown
}

/// Converts a diagnostic. Its help text becomes part of the message, because the protocol has no field for help.
pub(super) fn diagnostic(found: &Diagnostic, pieces: &Pieces, uri: &Uri) -> lsp_types::Diagnostic {
    let name = pieces.name();
    let own = found.labels.first().filter(|label| label.file == name);
    let mut message = found.message.clone();
    if let Some(label) = found.labels.first()
        && !label.message.is_empty()
    {
        message += &format!(": {}", label.message);
    }
    if let Some(help) = &found.help {
        message += &format!("\nhelp: {help}");
    }
    let related: Vec<DiagnosticRelatedInformation> = found
        .labels
        .iter()
        .skip(usize::from(own.is_some()))
        .filter_map(|label| {
            let here = label.file == name;
            let uri = if here {
                uri.clone()
            } else {
                uri_of(std::path::Path::new(&*label.file))?
            };
            // The text of the other file is not available here, so the label points to the start of that file.
            let range = if here {
                range(pieces, label.span)
            } else {
                lsp_types::Range::default()
            };
            Some(DiagnosticRelatedInformation {
                location: Location { uri, range },
                message: label.message.clone(),
            })
        })
        .collect();
    lsp_types::Diagnostic {
        range: own.map_or_else(lsp_types::Range::default, |label| range(pieces, label.span)),
        severity: Some(match found.severity {
            Severity::Error => DiagnosticSeverity::ERROR,
            Severity::Warning => DiagnosticSeverity::WARNING,
            Severity::Note => DiagnosticSeverity::INFORMATION,
        }),
        code: Some(NumberOrString::String(found.code.as_str().to_string())),
        source: Some("admire".to_string()),
        message,
        related_information: (!related.is_empty()).then_some(related),
        tags: (found.code == Code::Unreferenced).then(|| vec![DiagnosticTag::UNNECESSARY]),
        ..lsp_types::Diagnostic::default()
    }
}

/// Converts edits of a file. The replacement bytes are decoded as UTF-8.
pub(super) fn text_edits(edits: &[Edit], pieces: &Pieces) -> Vec<TextEdit> {
    let mut sorted: Vec<&Edit> = edits.iter().collect();
    sorted.sort_by_key(|edit| edit.span);
    let text = |edit: &Edit| String::from_utf8_lossy(&edit.replacement).into_owned();
    sorted
        .into_iter()
        .map(|edit| TextEdit::new(range(pieces, edit.span), text(edit)))
        .collect()
}
