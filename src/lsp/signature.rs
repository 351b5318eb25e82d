//! Signature help: the arguments of the function call at the cursor.

use lsp_types::{
    Documentation, ParameterInformation, ParameterLabel, SignatureHelp, SignatureHelpParams,
    SignatureInformation,
};

use super::cursor::locate_request;
use super::typing::open_call;
use super::workspace::Workspace;
use admire_syntax::grammar::find_function;

pub(super) fn signature(
    workspace: &Workspace,
    params: &SignatureHelpParams,
) -> Option<SignatureHelp> {
    let (_, file, offset) = locate_request(workspace, &params.text_document_position_params)?;
    let call = open_call(&file.document, offset)?;
    let def = find_function(call.name.as_bytes())?;
    let label = format!("{}({})", def.name, def.arguments);
    let names = def
        .arguments
        .split(',')
        .map(|name| name.trim_matches(['[', ']', ' ']));
    let parameters: Vec<ParameterInformation> = names
        .filter(|name| !name.is_empty())
        .map(|name| ParameterInformation {
            label: ParameterLabel::Simple(name.to_string()),
            documentation: None,
        })
        .collect();
    let active = call.argument.min(parameters.len().saturating_sub(1)) as u32;
    Some(SignatureHelp {
        signatures: vec![SignatureInformation {
            label,
            documentation: Some(Documentation::String(def.doc.to_string())),
            parameters: Some(parameters),
            active_parameter: Some(active),
        }],
        active_signature: Some(0),
        active_parameter: Some(active),
    })
}
