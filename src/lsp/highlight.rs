//! Highlighting of all places in one file that name the object under the cursor.

use lsp_types::{DocumentHighlight, DocumentHighlightKind, DocumentHighlightParams};

use super::cursor::{Thing, cursor, locate_request};
use super::position::range;
use super::references::{Role, places};
use super::workspace::Workspace;

pub(super) fn highlight(
    workspace: &Workspace,
    params: &DocumentHighlightParams,
) -> Option<Vec<DocumentHighlight>> {
    let (_, file, offset) = locate_request(workspace, &params.text_document_position_params)?;
    let Thing::Object(object) = cursor(&file.document, offset)?.thing else {
        return None;
    };
    let all = places(&file.document, object).into_iter();
    let shown = all.map(|(span, role)| DocumentHighlight {
        range: range(file.document.pieces(), span),
        kind: Some(match role {
            Role::Definition | Role::Name => DocumentHighlightKind::WRITE,
            Role::Reference => DocumentHighlightKind::READ,
        }),
    });
    Some(shown.collect())
}
