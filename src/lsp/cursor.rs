//! The item at a position of a file: an object, a name, a keyword or a function.

use std::path::{Path, PathBuf};

use lsp_types::TextDocumentPositionParams;

use super::document::Document;
use super::position::{offset, range};
use super::workspace::{File, Workspace, deck_argument, path_of};
use admire_syntax::catalogue::references;
use admire_syntax::expression::Node;
use admire_syntax::grammar::{ArgumentDef, FunctionDef, STATEMENTS, StatementDef};
use admire_syntax::text::Span;
use admire_syntax::{Argument, ObjectId, Reference, Statement, Value};

/// Kind of item at the cursor.
#[derive(Clone, Copy, Debug)]
pub(super) enum Thing {
    /// An object, by any of its ids or by the view name in its definition.
    Object(ObjectId),
    /// The keyword of a statement.
    Statement(&'static StatementDef),
    /// An argument of a statement.
    Argument(&'static StatementDef, &'static ArgumentDef),
    /// A function in an expression.
    Function(&'static FunctionDef),
    /// The name of a deck in a command file.
    Deck,
}

/// The item at a position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cursor {
    /// Indices of the piece and of the statement within that piece; `None` outside of statements.
    pub place: Option<(usize, usize)>,
    /// Kind of item.
    pub thing: Thing,
    /// Position of the item.
    pub span: Span,
    /// True for a view name, which is renamed independently of the id.
    pub is_name: bool,
}

/// Returns the file and the offset that a request refers to.
pub(super) fn locate_request<'w>(
    workspace: &'w Workspace,
    at: &TextDocumentPositionParams,
) -> Option<(PathBuf, &'w File, usize)> {
    let path = path_of(&at.text_document.uri);
    let file = workspace.file(&path)?;
    Some((path, file, offset(file.document.pieces(), at.position)))
}

/// Converts a span of a file to a location of the protocol.
pub(super) fn location(
    workspace: &Workspace,
    path: &Path,
    span: Span,
) -> Option<lsp_types::Location> {
    let file = workspace.file(path)?;
    Some(lsp_types::Location {
        uri: file.uri.clone(),
        range: range(file.document.pieces(), span),
    })
}

/// Returns the item at an offset of a document.
pub(super) fn cursor(document: &Document, offset: usize) -> Option<Cursor> {
    if let Some(head) = document.pieces().head()
        && touches(head.model, offset)
    {
        return Some(Cursor {
            place: None,
            thing: Thing::Deck,
            span: head.model,
            is_name: false,
        });
    }
    let (place, base, statement) = statement_at(document, offset)?;
    let inside = offset - base;
    let shift = |span: Span| Span::new(base + span.start(), base + span.end());
    let found = |thing, span, is_name| {
        Some(Cursor {
            place: Some(place),
            thing,
            span: shift(span),
            is_name,
        })
    };
    if let (Some(name), Some(object)) = (statement.view_name, statement.object())
        && touches(name, inside)
    {
        return found(Thing::Object(object), name, true);
    }
    if let (Some((_, span)), Some(object)) = (statement.id, statement.object())
        && touches(span, inside)
    {
        return found(Thing::Object(object), span, false);
    }
    if let Some(reference) = all_references(statement)
        .into_iter()
        .find(|reference| touches(reference.span, inside))
    {
        return found(
            Thing::Object((reference.space, reference.id)),
            reference.span,
            false,
        );
    }
    if let Some(span) = deck_argument(statement).filter(|span| touches(*span, inside)) {
        return found(Thing::Deck, span, false);
    }
    let def = statement.def?;
    if touches(statement.keyword, inside) {
        return found(Thing::Statement(def), statement.keyword, false);
    }
    let argument = statement
        .arguments
        .iter()
        .find(|argument| touches(argument.span, inside))?;
    if let Value::Function(expression) = &argument.value
        && let Some((function, span)) = function_at(&expression.root, inside)
    {
        return found(Thing::Function(function), span, false);
    }
    let of = argument.def?;
    let span = if touches(argument.name, inside) {
        argument.name
    } else {
        argument.span
    };
    found(Thing::Argument(def, of), span, false)
}

/// Returns the statement whose text or view name contains an offset, with its (piece, statement) indices and the offset of its piece.
pub(super) fn statement_at(
    document: &Document,
    offset: usize,
) -> Option<((usize, usize), usize, &Statement)> {
    let last = document.pieces().at(offset)?;
    // A statement that ends exactly where a piece starts belongs to the preceding piece.
    (last.saturating_sub(1)..=last).rev().find_map(|piece| {
        let base = document.pieces().start(piece);
        let inside = offset.checked_sub(base)?;
        let statements = document.pieces().live().get(piece)?.statements();
        let at = statements.iter().position(|statement| {
            touches(statement.span, inside)
                || statement
                    .view_name
                    .is_some_and(|name| touches(name, inside))
        })?;
        Some(((piece, at), base, &statements[at]))
    })
}

/// Returns every reference in a statement or command, including the ids that ACTIVATE and DEACTIVATE list.
pub(super) fn all_references(statement: &Statement) -> Vec<Reference> {
    let mut found: Vec<Reference> = references(statement).collect();
    if let Some(space) = switched(statement) {
        found.extend(statement.numbers("ID").iter().filter_map(|number| {
            let id = number.value as u32;
            (f64::from(id) == number.value && id > 0).then_some(Reference {
                space,
                id,
                span: number.span,
            })
        }));
    }
    found
}

/// Returns the id space of the ids in an ACTIVATE or DEACTIVATE command; `None` for any other command.
fn switched(command: &Statement) -> Option<&'static str> {
    if !matches!(command.kind(), Some("ACTIVATE" | "DEACTIVATE")) {
        return None;
    }
    let flags = command
        .arguments
        .iter()
        .filter(|argument| argument.value == Value::Flag);
    flags
        .filter_map(Argument::kind)
        .find_map(|kind| STATEMENTS.iter().find(|def| def.name == kind)?.id)
}

/// Returns the innermost function call whose name contains an offset.
fn function_at(node: &Node, offset: usize) -> Option<(&'static FunctionDef, Span)> {
    if let Node::Call { function, span, .. } = node {
        let name = span.to(span.start() + function.name.len());
        if touches(name, offset) {
            return Some((function, name));
        }
    }
    node.children()
        .into_iter()
        .find_map(|child| function_at(child, offset))
}

/// Returns true if a cursor at this offset touches a span. The offset after the last byte of the span counts too.
pub(super) fn touches(span: Span, offset: usize) -> bool {
    (span.start()..=span.end()).contains(&offset)
}
