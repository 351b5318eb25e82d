//! Quick fixes: the fix of each diagnostic, all safe fixes at once, and suppression comments.

use lsp_types::{
    CodeAction, CodeActionKind, CodeActionOrCommand, CodeActionParams, CodeActionResponse,
};

use super::convert::{diagnostic, text_edits};
use super::cursor::statement_at;
use super::document::Document;
use super::position::span;
use super::rename::workspace_edit;
use super::workspace::{File, Workspace, path_of};
use admire_syntax::diagnostic::{Applicability, Diagnostic};
use admire_syntax::safe_fixes;
use admire_syntax::text::{Edit, Span};

pub(super) fn fixes(
    workspace: &Workspace,
    params: &CodeActionParams,
) -> Option<CodeActionResponse> {
    let path = path_of(&params.text_document.uri);
    let file = workspace.file(&path)?;
    let asked = span(file.document.pieces(), params.range);
    let wanted = |kind: &CodeActionKind| {
        let only = params.context.only.as_ref();
        only.is_none_or(|only| {
            only.iter()
                .any(|own| kind.as_str().starts_with(own.as_str()))
        })
    };
    let mut all: Vec<Diagnostic> = file
        .document
        .complaints()
        .into_iter()
        .map(|found| found.diagnostic)
        .collect();
    all.retain(|found| file.settings.shows(found));
    let mut actions = Vec::new();
    let act = |title: String,
               kind: CodeActionKind,
               edits: Vec<Edit>,
               of: Option<&Diagnostic>,
               preferred: bool| {
        CodeActionOrCommand::CodeAction(CodeAction {
            title,
            kind: Some(kind),
            diagnostics: of.map(|found| vec![diagnostic(found, file.document.pieces(), &file.uri)]),
            edit: Some(workspace_edit(workspace, vec![(path.clone(), edits)])),
            is_preferred: preferred.then_some(true),
            ..CodeAction::default()
        })
    };
    if wanted(&CodeActionKind::QUICKFIX) {
        for found in all.iter().filter(|found| meets(found, asked)) {
            if let Some(fix) = &found.fix {
                let safe = fix.applicability == Applicability::Safe;
                actions.push(act(
                    fix.title.clone(),
                    CodeActionKind::QUICKFIX,
                    fix.edits.clone(),
                    Some(found),
                    safe,
                ));
            }
        }
        for found in all.iter().filter(|found| meets(found, asked)) {
            if let Some(edit) = silence(file, found) {
                let title = format!("ignore {} here", found.code.as_str());
                actions.push(act(
                    title,
                    CodeActionKind::QUICKFIX,
                    vec![edit],
                    Some(found),
                    false,
                ));
            }
        }
    }
    if wanted(&CodeActionKind::SOURCE_FIX_ALL) {
        let edits = safe_fixes(&all, &file.document.name());
        if !text_edits(&edits, file.document.pieces()).is_empty() {
            let title = "apply all safe fixes".to_string();
            actions.push(act(
                title,
                CodeActionKind::SOURCE_FIX_ALL,
                edits,
                None,
                false,
            ));
        }
    }
    Some(actions)
}

/// Returns true if a diagnostic overlaps the requested range.
fn meets(found: &Diagnostic, asked: Span) -> bool {
    let label = found.labels.first();
    label
        .is_some_and(|label| label.span.start() <= asked.end() && asked.start() <= label.span.end())
}

/// Returns the edit that inserts a suppression comment above a statement.
fn silence(file: &File, found: &Diagnostic) -> Option<Edit> {
    let document: &Document = &file.document;
    let ((piece, _), base, statement) = statement_at(document, found.labels.first()?.span.start())?;
    let bytes = document.pieces().pieces()[piece].source().bytes();
    let start =
        memchr::memrchr2(b'\n', b'\r', &bytes[..statement.span.start()]).map_or(0, |end| end + 1);
    let blank = bytes[start..statement.span.start()].trim_ascii().is_empty();
    // No comment can precede the title. A statement that shares its line with another statement has no line of its own for a comment above
    // it.
    if !blank || base + start == 0 {
        return None;
    }
    let end = if memchr::memmem::find(bytes, b"\r\n").is_some() {
        "\r\n"
    } else {
        "\n"
    };
    let comment = format!("! admire: ignore[{}]{end}", found.code.as_str());
    Some(Edit::new(Span::at(base + start), comment))
}
