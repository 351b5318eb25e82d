use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};

/// Reports parts that have mass but no CM marker, and parts whose CM marker is on another part.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for part in context.of_kind("PART") {
        let title = context.title(part);
        let Some(cm) = part.argument("CM") else {
            if let Some(mass) = part.argument("MASS")
                && part.first("MASS").is_some_and(|mass| mass > 0.0)
            {
                found.push(
                    context
                        .error(
                            Code::MassWithoutCm,
                            mass.value_span(),
                            format!(
                                "{title} has a mass but no CM marker: its centre of mass is unknown"
                            ),
                        )
                        .help("add a MARKER at the centre of mass and refer to it with CM="),
                );
            }
            continue;
        };
        let Some(marker) = context.marker(part, "CM") else {
            continue;
        };
        if let Some((space, id)) = context.body(marker)
            && (space, Some(id)) != ("part", part.number())
        {
            let message = format!(
                "the CM of {title} is {}, which is on {}/{id}",
                context.title(marker),
                space.to_uppercase()
            );
            found.push(
                context
                    .error(Code::MassWithoutCm, cm.value_span(), message)
                    .help("use a marker of this part as CM"),
            );
        }
    }
}
