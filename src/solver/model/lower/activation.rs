//! Lowering of the commands ACTIVATE and DEACTIVATE.

use crate::model::Model;
use crate::model::object::{EachList, Object};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Source;
use admire_syntax::{Argument, Number, Statement};

/// Visitor of the model's lists that activates or deactivates the chosen objects of one statement kind.
struct Turn<'a> {
    kind: &'static str,
    chosen: &'a dyn Fn(u32) -> bool,
    active: bool,
    found: usize,
}

impl EachList for Turn<'_> {
    fn list<T: Object>(&mut self, list: &mut Vec<T>, _: &mut Vec<T>) {
        for object in list {
            if object.is(self.kind) && (self.chosen)(object.header().id) {
                object.header_mut().active = self.active;
                self.found += 1;
            }
        }
    }
}

/// Activates or deactivates the objects that a command selects. Warns about each kind in the command for which no object is selected.
pub(super) fn activate(
    model: &mut Model,
    command: &Statement,
    source: &Source,
    active: bool,
) -> Vec<Diagnostic> {
    let numbers = |name: &str| -> Vec<u32> {
        command
            .numbers(name)
            .iter()
            .filter_map(Number::as_id)
            .collect()
    };
    let (ids, range) = (numbers("ID"), numbers("RANGE"));
    let chosen = |id: u32| {
        ids.contains(&id)
            || matches!(range[..], [from, to] if (from..=to).contains(&id))
            || command.has("ALL")
    };
    let mut diagnostics = Vec::new();
    for kind in command.arguments.iter().filter_map(Argument::kind) {
        if matches!(kind, "ID" | "RANGE" | "ALL") {
            continue;
        }
        let mut turn = Turn {
            kind,
            chosen: &chosen,
            active,
            found: 0,
        };
        model.each_list(&mut Model::default(), &mut turn);
        if turn.found == 0 && !matches!(kind, "FRICTION" | "CLEARANCE" | "FEMDATA") {
            diagnostics.push(
                Diagnostic::warning(
                    Code::UndefinedId,
                    format!("no {kind} has an id that this command selects"),
                )
                .label(source.name(), command.span, ""),
            );
        }
    }
    diagnostics
}
