//! Every place that names an object, in a deck and in its command files.

use std::path::{Path, PathBuf};

use lsp_types::{Location, ReferenceParams};

use super::cursor::{Thing, all_references, cursor, locate_request, location};
use super::document::Document;
use super::workspace::Workspace;
use admire_syntax::ObjectId;
use admire_syntax::text::Span;

/// Role of a place in the text that names an object.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Role {
    /// Id of the object in its definition.
    Definition,
    /// View name of the object in its definition.
    Name,
    /// Id of the object outside of its definition.
    Reference,
}

/// Returns the spans in a document that name an object, each with its role.
pub(super) fn places(document: &Document, object: ObjectId) -> Vec<(Span, Role)> {
    let mut found = Vec::new();
    let mut pieces = document.referring(object);
    pieces.extend(document.definitions(object).iter().map(|(piece, _)| *piece));
    if document.is_command_file() {
        // ACTIVATE and DEACTIVATE name objects by plain numbers, which are not indexed as references.
        pieces = (0..document.pieces().pieces().len()).collect();
    }
    pieces.sort_unstable();
    pieces.dedup();
    let own = if document.is_command_file() {
        // A command redefines an object that the deck defines.
        Role::Reference
    } else {
        Role::Definition
    };
    for piece in pieces {
        let base = document.pieces().start(piece);
        let shift = |span: Span| Span::new(base + span.start(), base + span.end());
        for statement in document.pieces().pieces()[piece].statements() {
            if let Some((_, span)) = statement.id.filter(|_| statement.object() == Some(object)) {
                found.extend(statement.view_name.map(|name| (shift(name), Role::Name)));
                found.push((shift(span), own));
            }
            for reference in all_references(statement) {
                if (reference.space, reference.id) == object {
                    found.push((shift(reference.span), Role::Reference));
                }
            }
        }
    }
    found
}

/// Returns all places that name an object, in a deck and in the command files that run the deck. Without a deck, only the file itself is
/// searched.
pub(super) fn everywhere(
    workspace: &mut Workspace,
    path: &Path,
    offset: usize,
    object: ObjectId,
) -> Vec<(PathBuf, Span, Role)> {
    let files = workspace.together(path);
    let commands = |path: &Path| {
        workspace
            .file(path)
            .is_some_and(|file| file.document.is_command_file())
    };
    let deck = if commands(path) {
        workspace.deck_of(path, offset)
    } else {
        Some(path.to_path_buf())
    };
    let mut found = Vec::new();
    for file in files {
        let Some(document) = workspace.file(&file).map(|file| &file.document) else {
            continue;
        };
        let of_deck = |at: usize| {
            if document.is_command_file() {
                workspace.deck_of(&file, at) == deck
            } else {
                Some(&file) == deck.as_ref()
            }
        };
        let all = places(document, object).into_iter();
        found.extend(
            all.filter(|(span, _)| of_deck(span.start()))
                .map(|(span, role)| (file.clone(), span, role)),
        );
    }
    found
}

pub(super) fn references(
    workspace: &mut Workspace,
    params: &ReferenceParams,
) -> Option<Vec<Location>> {
    let (path, file, offset) = locate_request(workspace, &params.text_document_position)?;
    let Thing::Object(object) = cursor(&file.document, offset)?.thing else {
        return None;
    };
    let all = everywhere(workspace, &path, offset, object);
    let wanted = |role: Role| match role {
        Role::Definition => params.context.include_declaration,
        Role::Name => false,
        Role::Reference => true,
    };
    let all = all.into_iter().filter(|(_, _, role)| wanted(*role));
    Some(
        all.filter_map(|(path, span, _)| location(workspace, &path, span))
            .collect(),
    )
}
