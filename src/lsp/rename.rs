//! Renaming of ids and view names. All references in the deck and in the command files that run the deck are changed too.

use std::path::{Path, PathBuf};

use lsp_types::{
    DocumentChanges, OneOf, OptionalVersionedTextDocumentIdentifier, PrepareRenameResponse,
    RenameParams, TextDocumentEdit, TextDocumentPositionParams, WorkspaceEdit,
};

use super::convert::text_edits;
use super::cursor::{Cursor, Thing, cursor, locate_request};
use super::position::range;
use super::references::{Role, everywhere};
use super::refused::Refused;
use super::workspace::Workspace;
use admire_syntax::renumber::{Renumbering, renumber};
use admire_syntax::text::Edit;
use admire_syntax::{CommandFile, Dataset, ObjectId};

/// Returns the range of the id or view name at the cursor that would be renamed.
pub(super) fn prepare(
    workspace: &Workspace,
    params: &TextDocumentPositionParams,
) -> Result<Option<PrepareRenameResponse>, Refused> {
    let found = locate_request(workspace, params)
        .and_then(|(_, file, offset)| Some((file, cursor(&file.document, offset)?)));
    let Some((
        file,
        Cursor {
            thing: Thing::Object(_),
            span,
            ..
        },
    )) = found
    else {
        return Ok(None);
    };
    Ok(Some(PrepareRenameResponse::Range(range(
        file.document.pieces(),
        span,
    ))))
}

/// Returns the edits that give an object a new id or a new view name.
pub(super) fn rename(
    workspace: &mut Workspace,
    params: &RenameParams,
) -> Result<Option<WorkspaceEdit>, Refused> {
    let Some((path, file, offset)) = locate_request(workspace, &params.text_document_position)
    else {
        return Ok(None);
    };
    let Some(Cursor {
        thing: Thing::Object(object),
        is_name,
        ..
    }) = cursor(&file.document, offset)
    else {
        return Err(refused(
            "only ids and view names can be renamed; place the cursor on one of them",
        ));
    };
    let new = params.new_name.trim();
    let all = match new.parse::<u32>() {
        Ok(id) if !is_name => new_id(workspace, &path, offset, object, id)?,
        Err(_) if !is_name && new.bytes().all(|byte| byte.is_ascii_digit()) => {
            return Err(refused(&format!(
                "an id is a whole number up to {}, not `{new}`",
                u32::MAX
            )));
        }
        _ => new_name(workspace, &path, offset, object, new)?,
    };
    Ok(Some(workspace_edit(workspace, all)))
}

fn refused(why: &str) -> Refused {
    Refused::Request(why.to_string())
}

/// Converts edits in several files to protocol types.
pub(super) fn workspace_edit(
    workspace: &Workspace,
    all: Vec<(PathBuf, Vec<Edit>)>,
) -> WorkspaceEdit {
    let of_file = |(path, edits): (PathBuf, Vec<Edit>)| {
        let file = workspace.file(&path).filter(|_| !edits.is_empty())?;
        Some(TextDocumentEdit {
            text_document: OptionalVersionedTextDocumentIdentifier {
                uri: file.uri.clone(),
                version: file.version,
            },
            edits: text_edits(&edits, file.document.pieces())
                .into_iter()
                .map(OneOf::Left)
                .collect(),
        })
    };
    WorkspaceEdit {
        document_changes: Some(DocumentChanges::Edits(
            all.into_iter().filter_map(of_file).collect(),
        )),
        ..WorkspaceEdit::default()
    }
}

fn new_name(
    workspace: &mut Workspace,
    path: &Path,
    offset: usize,
    object: ObjectId,
    new: &str,
) -> Result<Vec<(PathBuf, Vec<Edit>)>, Refused> {
    if new.is_empty() {
        return Err(refused("the view name is empty"));
    }
    if new.contains(['\n', '\r', '\'']) {
        return Err(refused(
            "the view name contains a single quote or a line break",
        ));
    }
    let places = everywhere(workspace, path, offset, object);
    let names = places
        .into_iter()
        .filter(|(_, _, role)| *role == Role::Name);
    let all: Vec<_> = names
        .map(|(path, span, _)| (path, vec![Edit::new(span, new)]))
        .collect();
    if all.is_empty() {
        let (space, id) = object;
        return Err(refused(&format!(
            "{}/{id} has no view name, so the new name must be an id: a whole number",
            space.to_uppercase()
        )));
    }
    Ok(all)
}

fn new_id(
    workspace: &mut Workspace,
    path: &Path,
    offset: usize,
    object: ObjectId,
    new: u32,
) -> Result<Vec<(PathBuf, Vec<Edit>)>, Refused> {
    if new == 0 {
        return Err(refused("an id is greater than zero"));
    }
    let files = workspace.together(path);
    let document = |path: &PathBuf| workspace.file(path).map(|file| &file.document);
    let is_commands = |path: &PathBuf| document(path).is_some_and(super::Document::is_command_file);
    let deck = if is_commands(&path.to_path_buf()) {
        workspace.deck_of(path, offset)
    } else {
        Some(path.to_path_buf())
    };
    let Some((deck, of_deck)) = deck.and_then(|deck| Some((deck.clone(), document(&deck)?))) else {
        return Err(refused(
            "the dataset that this command file loads cannot be read",
        ));
    };
    let dataset = Dataset::parse(of_deck.pieces().source()).value;
    let commands: Vec<(&PathBuf, CommandFile)> = files
        .iter()
        .filter(|file| is_commands(file))
        .filter_map(|file| {
            Some((
                file,
                CommandFile::parse(document(file)?.pieces().source()).value,
            ))
        })
        .collect();
    let parsed: Vec<&CommandFile> = commands.iter().map(|(_, file)| file).collect();
    let renumbering = Renumbering::from([(object, new)]);
    let done = renumber(&dataset, &parsed, &renumbering)
        .map_err(|found| Refused::Request(found.message))?;
    let mut all = vec![(deck.clone(), done.value.dataset)];
    for ((file, _), edits) in commands.iter().zip(done.value.commands) {
        // Other commands in the file may belong to another deck.
        let here = |edit: &Edit| workspace.deck_of(file, edit.span.start()).as_ref() == Some(&deck);
        all.push(((*file).clone(), edits.into_iter().filter(here).collect()));
    }
    Ok(all)
}
