//! Completion of statements (as snippets), arguments, values, ids with names, and functions.

use lsp_types::{
    CompletionItem, CompletionItemKind, CompletionParams, CompletionResponse, CompletionTextEdit,
    Documentation, InsertTextFormat, MarkupContent, MarkupKind, Range, TextEdit,
};

use super::cursor::locate_request;
use super::document::Document;
use super::position::range;
use super::snippets::snippet;
use super::typing::{Typing, place};
use super::workspace::Workspace;
use admire_syntax::describe;
use admire_syntax::grammar::{ArgumentDef, FUNCTIONS, Role, STATEMENTS, StatementDef, ValueKind};

/// Largest number of ids offered. A longer list is marked incomplete, and the editor requests it again with the next keystroke.
const MOST_IDS: usize = 2000;

pub(super) fn completion(
    workspace: &mut Workspace,
    params: &CompletionParams,
) -> Option<CompletionResponse> {
    let (path, file, offset) = locate_request(workspace, &params.text_document_position)?;
    let commands = file.document.is_command_file();
    let found = place(&file.document, offset)?;
    let typed = range(file.document.pieces(), found.word);
    let deck = if commands {
        let deck = workspace.deck_of(&path, offset);
        deck.filter(|deck| workspace.read(deck))
    } else {
        Some(path.clone())
    };
    let document = deck.and_then(|deck| Some(&workspace.file(&deck)?.document));
    let own = &workspace.file(&path)?.document;
    let prefix = typed_digits(own, found.word);
    let items = match found.typing {
        Typing::Keyword => statements(own, typed),
        Typing::Id(def) if commands => ids(document, def.id, &prefix, typed),
        Typing::Id(def) => free_id(own, def, typed).into_iter().collect(),
        Typing::Argument(def, there) => arguments(def, &there, typed),
        Typing::Value(argument) => values(argument, typed),
        Typing::Reference(space) => ids(document, Some(space), &prefix, typed),
        Typing::Expression => functions(typed),
    };
    let incomplete = items.len() >= MOST_IDS;
    Some(CompletionResponse::List(lsp_types::CompletionList {
        is_incomplete: incomplete,
        items,
    }))
}

fn typed_digits(document: &Document, word: admire_syntax::text::Span) -> String {
    let pieces = document.pieces();
    let Some(at) = pieces.at(word.start()) else {
        return String::new();
    };
    let bytes = pieces.pieces()[at].source().bytes();
    let start = word.start() - pieces.start(at);
    let end = (start + word.len()).min(bytes.len());
    String::from_utf8_lossy(&bytes[start..end]).into_owned()
}

fn item(label: &str, kind: CompletionItemKind, new: String, typed: Range) -> CompletionItem {
    CompletionItem {
        label: label.to_string(),
        kind: Some(kind),
        filter_text: Some(label.to_string()),
        text_edit: Some(CompletionTextEdit::Edit(TextEdit::new(typed, new))),
        ..CompletionItem::default()
    }
}

fn page(text: &str) -> Option<Documentation> {
    Some(Documentation::MarkupContent(MarkupContent {
        kind: MarkupKind::Markdown,
        value: format!("```text\n{text}```"),
    }))
}

/// Returns all statements that the file may contain. A statement with a shipped example is offered as a snippet.
fn statements(document: &Document, typed: Range) -> Vec<CompletionItem> {
    let commands = document.is_command_file();
    let role = if commands {
        Role::Command
    } else {
        Role::Dataset
    };
    let here = STATEMENTS
        .iter()
        .filter(|def| def.role == Role::Both || def.role == role);
    here.map(|def| {
        // A command that redefines an object states only what changes, so a snippet of the whole statement would not fit.
        let whole = snippet(def.name).filter(|_| !commands || def.role == Role::Command);
        let new = match whole {
            Some(text) => {
                text.replacen("${1:ID}", &format!("${{1:{}}}", next_id(document, def)), 1)
            }
            None => format!("{}/", def.name),
        };
        CompletionItem {
            detail: Some(def.doc.to_string()),
            documentation: page(&describe::statement(def)),
            insert_text_format: whole.map(|_| InsertTextFormat::SNIPPET),
            ..item(def.name, CompletionItemKind::CLASS, new, typed)
        }
    })
    .collect()
}

/// Returns the next free id of a statement kind: the largest id in the document plus 1.
fn next_id(document: &Document, def: &StatementDef) -> u32 {
    let own = document
        .objects()
        .filter(|((space, _), _)| Some(*space) == def.id);
    own.map(|((_, id), _)| id)
        .max()
        .map_or(1, |id| id.saturating_add(1))
}

fn free_id(document: &Document, def: &StatementDef, typed: Range) -> Option<CompletionItem> {
    def.id?;
    let id = next_id(document, def).to_string();
    Some(CompletionItem {
        detail: Some(format!("next free id of {}", def.name)),
        ..item(&id, CompletionItemKind::VALUE, id.clone(), typed)
    })
}

fn arguments(def: &'static StatementDef, there: &[&str], typed: Range) -> Vec<CompletionItem> {
    let again = |argument: &ArgumentDef| def.name == "SPLINE" && argument.name == "Y";
    let missing = def
        .arguments
        .iter()
        .filter(|a| again(a) || !there.contains(&a.name));
    missing
        .map(|argument| {
            let is_flag = argument.kind == ValueKind::Flag;
            let new = if is_flag {
                argument.name.to_string()
            } else {
                format!("{} = ", argument.name)
            };
            let mut details = describe::details(argument);
            details.insert(0, format!("{}{}", argument.name, describe::value(argument)));
            CompletionItem {
                detail: Some(details.join("; ")),
                documentation: Some(Documentation::String(argument.doc.to_string())),
                // Required arguments come first.
                sort_text: Some(format!("{}{}", u8::from(!argument.required), argument.name)),
                ..item(argument.name, CompletionItemKind::PROPERTY, new, typed)
            }
        })
        .collect()
}

/// Returns the keywords that an argument accepts; for an argument with numbers, its default.
fn values(argument: &'static ArgumentDef, typed: Range) -> Vec<CompletionItem> {
    if let ValueKind::Choice(choices) = argument.kind {
        let word = |choice: &admire_syntax::grammar::Choice| {
            item(
                choice.name,
                CompletionItemKind::ENUM_MEMBER,
                choice.name.to_string(),
                typed,
            )
        };
        return choices.iter().map(word).collect();
    }
    if argument.default.is_empty() {
        return Vec::new();
    }
    let numbers: Vec<String> = argument.default.iter().map(f64::to_string).collect();
    let text = numbers.join(", ");
    vec![CompletionItem {
        detail: Some(format!("default value of {}", argument.name)),
        ..item(&text, CompletionItemKind::VALUE, text.clone(), typed)
    }]
}

/// Returns the ids of an id space (the ids of one kind of object) that match the typed prefix. An id matches if it starts with the prefix,
/// or if the name of its object contains the prefix.
fn ids(
    document: Option<&Document>,
    space: Option<&str>,
    prefix: &str,
    typed: Range,
) -> Vec<CompletionItem> {
    let Some(document) = document else {
        return Vec::new();
    };
    let named = |place: (usize, usize)| {
        let name = document.statement(place).view_name?;
        Some(
            document.pieces().pieces()[place.0]
                .source()
                .text(name)
                .into_owned(),
        )
    };
    let lower = prefix.to_lowercase();
    let own = document.objects().filter(|((of, _), _)| Some(*of) == space);
    let mut found: Vec<(u32, (usize, usize), Option<String>)> = own
        .map(|((_, id), place)| (id, place, named(place)))
        .filter(|(id, _, name)| {
            let by_name = name
                .as_ref()
                .is_some_and(|name| name.to_lowercase().contains(&lower));
            by_name || id.to_string().starts_with(prefix)
        })
        .collect();
    found.sort_unstable();
    found.truncate(MOST_IDS);
    found
        .into_iter()
        .map(|(id, place, name)| {
            let text = id.to_string();
            let def = document.statement(place).def;
            let label = name.map_or_else(|| text.clone(), |name| format!("{text} {name}"));
            CompletionItem {
                detail: def.map(|def| format!("{}/{id}", def.name)),
                sort_text: Some(format!("{id:010}")),
                ..item(&label, CompletionItemKind::REFERENCE, text, typed)
            }
        })
        .collect()
}

fn functions(typed: Range) -> Vec<CompletionItem> {
    FUNCTIONS
        .iter()
        .map(|def| {
            let called = !def.arguments.is_empty();
            let new = if called {
                format!("{}($1)$0", def.name)
            } else {
                def.name.to_string()
            };
            let detail = if called {
                format!("{}({})", def.name, def.arguments)
            } else {
                def.name.to_string()
            };
            CompletionItem {
                detail: Some(detail),
                documentation: page(&describe::function(def)),
                insert_text_format: called.then_some(InsertTextFormat::SNIPPET),
                ..item(def.name, CompletionItemKind::FUNCTION, new, typed)
            }
        })
        .collect()
}
