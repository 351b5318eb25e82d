//! Dispatch of requests to their handlers.

use std::collections::BTreeMap;

use lsp_types::request::{self, Request};
use serde_json::Value;

use super::refused::Refused;
use super::workspace::Workspace;
use super::{
    completion, definition, fixes, folding, format, highlight, hover, references, rename,
    signature, symbols,
};

type RequestHandler = Box<dyn Fn(&mut Workspace, Value) -> Result<Value, Refused> + Send>;

/// Handlers of requests, keyed by method.
#[derive(Default)]
pub(super) struct Routes(BTreeMap<&'static str, RequestHandler>);

impl Routes {
    /// Creates the routes of all supported requests.
    pub(crate) fn all() -> Self {
        let mut routes = Self::default();
        routes.add::<request::HoverRequest>(|w, p| Ok(hover::hover(w, &p)));
        routes.add::<request::GotoDefinition>(|w, p| Ok(definition::definition(w, &p)));
        routes.add::<request::References>(|w, p| Ok(references::references(w, &p)));
        routes.add::<request::DocumentHighlightRequest>(|w, p| Ok(highlight::highlight(w, &p)));
        routes.add::<request::DocumentSymbolRequest>(|w, p| Ok(symbols::of_document(w, &p)));
        routes.add::<request::WorkspaceSymbolRequest>(|w, p| Ok(symbols::of_workspace(w, &p)));
        routes.add::<request::FoldingRangeRequest>(|w, p| Ok(folding::folding(w, &p)));
        routes.add::<request::PrepareRenameRequest>(|w, p| rename::prepare(w, &p));
        routes.add::<request::Rename>(|w, p| rename::rename(w, &p));
        routes.add::<request::CodeActionRequest>(|w, p| Ok(fixes::fixes(w, &p)));
        routes.add::<request::RangeFormatting>(|w, p| Ok(format::range(w, &p)));
        routes.add::<request::Formatting>(|w, p| Ok(format::document(w, &p)));
        routes.add::<request::Completion>(|w, p| Ok(completion::completion(w, &p)));
        routes.add::<request::SignatureHelpRequest>(|w, p| Ok(signature::signature(w, &p)));
        routes
    }

    /// Adds the handler of a request.
    pub(crate) fn add<R: Request>(
        &mut self,
        answer: impl Fn(&mut Workspace, R::Params) -> Result<R::Result, Refused> + Send + 'static,
    ) where
        R::Params: 'static,
    {
        let answer = move |workspace: &mut Workspace, params: Value| {
            let params = serde_json::from_value(params)
                .map_err(|error| Refused::Parameters(error.to_string()))?;
            let result = answer(workspace, params)?;
            serde_json::to_value(result).map_err(|error| Refused::Request(error.to_string()))
        };
        self.0.insert(R::METHOD, Box::new(answer));
    }

    /// Answers a request by calling its handler.
    pub(crate) fn answer(
        &self,
        workspace: &mut Workspace,
        method: &str,
        params: Value,
    ) -> Result<Value, Refused> {
        let answer = self.0.get(method).ok_or(Refused::Unknown)?;
        answer(workspace, params)
    }
}
