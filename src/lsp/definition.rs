//! Go to definition, for an object or for a deck that a command file names.

use lsp_types::{GotoDefinitionParams, GotoDefinitionResponse, Location};

use super::cursor::{Thing, cursor, locate_request, location};
use super::workspace::Workspace;
use admire_syntax::text::Span;

pub(super) fn definition(
    workspace: &mut Workspace,
    params: &GotoDefinitionParams,
) -> Option<GotoDefinitionResponse> {
    let (path, file, offset) = locate_request(workspace, &params.text_document_position_params)?;
    let commands = file.document.is_command_file();
    let thing = cursor(&file.document, offset)?.thing;
    let deck = if commands {
        let deck = workspace.deck_of(&path, offset);
        deck.filter(|deck| workspace.read(deck))?
    } else {
        path
    };
    let found: Vec<Location> = match thing {
        Thing::Object(object) => {
            let document = &workspace.file(&deck)?.document;
            let places = document.definitions(object).into_iter();
            let spans = places.map(|place| {
                let statement = document.statement(place);
                let base = document.pieces().start(place.0);
                let span = statement
                    .id
                    .map_or(statement.keyword, |(_, id)| statement.keyword.join(id));
                Span::new(base + span.start(), base + span.end())
            });
            spans
                .filter_map(|span| location(workspace, &deck, span))
                .collect()
        }
        Thing::Deck => location(workspace, &deck, Span::at(0))
            .into_iter()
            .collect(),
        Thing::Statement(_) | Thing::Argument(..) | Thing::Function(_) => return None,
    };
    Some(GotoDefinitionResponse::Array(found))
}
