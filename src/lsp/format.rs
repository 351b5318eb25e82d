//! Formatting of a range or of a whole file.

use lsp_types::{DocumentFormattingParams, DocumentRangeFormattingParams, TextEdit, Uri};

use super::convert::text_edits;
use super::document::Document;
use super::position::span;
use super::workspace::{Workspace, path_of};
use admire_syntax::layout::{layout, layout_of_commands};
use admire_syntax::text::Span;
use admire_syntax::{CommandFile, Dataset};

pub(super) fn range(
    workspace: &Workspace,
    params: &DocumentRangeFormattingParams,
) -> Option<Vec<TextEdit>> {
    let asked = |document: &Document| span(document.pieces(), params.range);
    edits(workspace, &params.text_document.uri, asked)
}

pub(super) fn document(
    workspace: &Workspace,
    params: &DocumentFormattingParams,
) -> Option<Vec<TextEdit>> {
    let all = |document: &Document| Span::new(0, document.pieces().size());
    edits(workspace, &params.text_document.uri, all)
}

fn edits(
    workspace: &Workspace,
    uri: &Uri,
    asked: impl Fn(&Document) -> Span,
) -> Option<Vec<TextEdit>> {
    let document = &workspace.file(&path_of(uri))?.document;
    let (source, asked) = (document.pieces().source(), asked(document));
    let edits = if document.is_command_file() {
        layout_of_commands(&CommandFile::parse(source).value, asked)
    } else {
        layout(&Dataset::parse(source).value, asked)
    };
    Some(text_edits(&edits, document.pieces()))
}
