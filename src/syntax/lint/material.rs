use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};

/// Reports parts with a material that the deck does not define.
///
/// Material names are checked only if the deck itself defines named materials, because ADAMS/View also writes names from its own database.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let source = context.dataset.source();
    let names: Vec<String> = context
        .of_kind("MATERIAL")
        .filter_map(|material| Some(material.text("NAME", source)?.to_uppercase()))
        .collect();
    for part in context.of_kind("PART") {
        let (Some(argument), Some(name)) =
            (part.argument("MATERIAL"), part.text("MATERIAL", source))
        else {
            continue;
        };
        let known = match name.trim().parse::<u32>() {
            Ok(id) => context.find("material", id).is_some(),
            Err(_) => names.is_empty() || names.contains(&name.trim().to_uppercase()),
        };
        if !known {
            let message = format!(
                "{} refers to the material {}, which is not in this dataset",
                context.title(part),
                name.trim()
            );
            found.push(
                context
                    .warning(Code::UndefinedId, argument.value_span(), message)
                    .help("add this MATERIAL, or refer to an existing one"),
            );
        }
    }
}
