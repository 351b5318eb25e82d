//! Statements as symbols: all statements of one file, or the statements in the whole workspace that match a query.

use lsp_types::{
    DocumentSymbol, DocumentSymbolParams, DocumentSymbolResponse, Location, OneOf, SymbolKind,
    WorkspaceSymbol, WorkspaceSymbolParams, WorkspaceSymbolResponse,
};

use super::document::Document;
use super::position::{PieceLines, range};
use super::workspace::{File, Workspace, normal, path_of};
use admire_syntax::Statement;
use admire_syntax::text::{Source, Span};

/// Largest number of symbols returned by a workspace query.
const MOST_FOUND: usize = 1000;
/// Largest number of files searched in the editor's folders.
const MOST_FILES: usize = 500;

pub(super) fn of_document(
    workspace: &Workspace,
    params: &DocumentSymbolParams,
) -> Option<DocumentSymbolResponse> {
    let file = workspace.file(&path_of(&params.text_document.uri))?;
    let document = &file.document;
    let mut found = Vec::new();
    for (at, piece) in document.pieces().live().iter().enumerate() {
        let lines = PieceLines::of(document.pieces(), at);
        for statement in piece.statements() {
            let Some(def) = statement.def else { continue };
            #[allow(deprecated)] // The protocol's type has the old field.
            found.push(DocumentSymbol {
                name: name_of(statement, piece.source()),
                detail: Some(def.doc.to_string()),
                kind: kind_of(def.name),
                tags: None,
                deprecated: None,
                range: lines.range(statement.span),
                selection_range: lines.range(head_of(statement)),
                children: None,
            });
        }
    }
    Some(DocumentSymbolResponse::Nested(found))
}

pub(super) fn of_workspace(
    workspace: &mut Workspace,
    params: &WorkspaceSymbolParams,
) -> Option<WorkspaceSymbolResponse> {
    for path in files_below(&workspace.folders) {
        workspace.read(&path);
    }
    let query = params.query.to_lowercase();
    let mut found = Vec::new();
    for file in workspace.all_files() {
        matching(file, &query, &mut found);
    }
    Some(WorkspaceSymbolResponse::Nested(found))
}

fn matching(file: &File, query: &str, found: &mut Vec<WorkspaceSymbol>) {
    let document: &Document = &file.document;
    for ((piece, _), base, statement) in document.statements() {
        if found.len() >= MOST_FOUND {
            return;
        }
        let (Some(def), Some(_)) = (statement.def, statement.id) else {
            continue;
        };
        let name = name_of(statement, document.pieces().pieces()[piece].source());
        if !name.to_lowercase().contains(query) {
            continue;
        }
        let head = head_of(statement);
        let span = Span::new(base + head.start(), base + head.end());
        found.push(WorkspaceSymbol {
            name,
            kind: kind_of(def.name),
            tags: None,
            container_name: Some(file.document.name().to_string()),
            location: OneOf::Left(Location {
                uri: file.uri.clone(),
                range: range(document.pieces(), span),
            }),
            data: None,
        });
    }
}

/// Returns the decks and command files in the given folders and their subfolders.
fn files_below(folders: &[std::path::PathBuf]) -> Vec<std::path::PathBuf> {
    let mut found = Vec::new();
    let mut open = folders.to_vec();
    while let Some(folder) = open.pop() {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        for entry in entries {
            let path = entry.path();
            let hidden = entry.file_name().to_string_lossy().starts_with('.');
            let is_deck = path.extension().is_some_and(|extension| {
                extension.eq_ignore_ascii_case("adm") || extension.eq_ignore_ascii_case("acf")
            });
            match entry.file_type() {
                Ok(kind) if kind.is_dir() && !hidden => open.push(path),
                Ok(kind) if kind.is_file() && is_deck => found.push(normal(&path)),
                _ => {}
            }
            if found.len() >= MOST_FILES {
                return found;
            }
        }
    }
    found
}

/// Returns the name of a symbol, such as `BUSHING/12 front_arm`.
fn name_of(statement: &Statement, source: &Source) -> String {
    let kind = statement.kind().unwrap_or_default();
    let mut name = match statement.number() {
        Some(id) => format!("{kind}/{id}"),
        None => kind.to_string(),
    };
    if let Some(own) = statement.view_name {
        name += " ";
        name += &source.text(own);
    }
    name
}

/// Returns the span from the keyword of a statement to its id.
fn head_of(statement: &Statement) -> Span {
    let id = statement.id.map_or(statement.keyword, |(_, id)| id);
    statement.keyword.join(id)
}

fn kind_of(statement: &str) -> SymbolKind {
    match statement {
        "PART" | "POINT_MASS" | "FLEX_BODY" | "FE_PART" => SymbolKind::CLASS,
        "MARKER" => SymbolKind::FIELD,
        "JOINT" | "JPRIM" | "COUPLER" | "GEAR" | "GCON" | "PTCV" | "CVCV" => SymbolKind::INTERFACE,
        "MOTION" | "SFORCE" | "VFORCE" | "VTORQUE" | "GFORCE" | "NFORCE" | "BUSHING" | "BEAM"
        | "FIELD" | "SPRINGDAMPER" | "CONTACT" | "FRICTION" => SymbolKind::EVENT,
        "VARIABLE" | "DIFF" => SymbolKind::VARIABLE,
        "ARRAY" | "MATRIX" | "SPLINE" => SymbolKind::ARRAY,
        "STRING" => SymbolKind::STRING,
        "REQUEST" | "MREQUEST" | "SENSOR" => SymbolKind::FUNCTION,
        "UNITS" | "EQUILIBRIUM" | "INTEGRATOR" | "RESULTS" | "OUTPUT" | "ACCGRAV" => {
            SymbolKind::CONSTANT
        }
        _ => SymbolKind::OBJECT,
    }
}
