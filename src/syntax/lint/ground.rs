use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};

/// Reports a dataset that has no ground part or several ground parts.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let mut grounds = context.of_kind("PART").filter(|part| part.has("GROUND"));
    let Some(first) = grounds.next() else {
        // A file without any part is only a piece of a dataset and is not reported.
        if let Some(part) = context.of_kind("PART").next() {
            found.push(
                context
                    .error(
                        Code::NoGround,
                        part.head(),
                        "this dataset has no ground part".to_string(),
                    )
                    .help("add a ground part with a free id, such as PART/1, GROUND"),
            );
        }
        return;
    };
    for second in grounds {
        let message = format!(
            "{} is a second ground part; the first is {}",
            context.title(second),
            context.title(first)
        );
        found.push(
            context
                .error(Code::NoGround, second.keyword, message)
                .help("remove GROUND from one of them"),
        );
    }
}
