//! Renumbering of objects: new ids for their statements and for all references to them in arguments, functions and commands.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::{Argument, CommandFile, Dataset, Number, Statement, Value};
use crate::diagnostic::{Checked, Code, Diagnostic};
use crate::grammar::{STATEMENTS, ValueKind};
use crate::text::{Edit, Source, Span};

/// New ids; the key is id space (`marker`, `part`, `bushing`) and old id. Objects without an entry keep their ids.
pub type Renumbering = BTreeMap<(&'static str, u32), u32>;

/// Edits that carry out a renumbering.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct RenumberingEdits {
    /// Edits of the text of the dataset.
    pub dataset: Vec<Edit>,
    /// Edits of each command file, in the order in which the files were given.
    pub commands: Vec<Vec<Edit>>,
}

/// Assigns the ids `first`, `first + step`, ... to all statements of a kind, in order of appearance. `kind` is the full keyword in
/// capitals.
pub fn in_order(dataset: &Dataset, kind: &str, first: u32, step: u32) -> Renumbering {
    let mut renumbering = Renumbering::new();
    let mut next = first;
    for statement in dataset.statements() {
        if let (Some(def), Some(id)) = (statement.def, statement.number())
            && def.name == kind
            && let Some(space) = def.id
        {
            renumbering.entry((space, id)).or_insert_with(|| {
                let new = next;
                next = next.saturating_add(step);
                new
            });
        }
    }
    renumbering
}

/// Returns the edits that give objects new ids, in the dataset and in the command files that belong to it.
///
/// Numbers in USER calls and in arrays for subroutines may be ids as well. Such numbers are reported but not changed.
///
/// # Errors
/// Returns `duplicate-id` if two objects would get the same id.
pub fn renumber(
    dataset: &Dataset,
    commands: &[&CommandFile],
    renumbering: &Renumbering,
) -> Result<Checked<RenumberingEdits>, Diagnostic> {
    refuse_duplicates(dataset, renumbering)?;
    let mut edits = RenumberingEdits::default();
    let mut places = Vec::new();
    for statement in dataset.statements() {
        references(dataset.source(), statement, renumbering, &mut edits.dataset);
        unknowable(dataset.source(), statement, renumbering, &mut places);
    }
    for file in commands {
        let mut own = Vec::new();
        for command in file.commands() {
            references(file.source(), command, renumbering, &mut own);
            activation(dataset, command, renumbering, &mut own);
            unknowable(file.source(), command, renumbering, &mut places);
        }
        edits.commands.push(own);
    }
    Ok(Checked {
        value: edits,
        diagnostics: one_warning(&places),
    })
}

fn refuse_duplicates(dataset: &Dataset, renumbering: &Renumbering) -> Result<(), Diagnostic> {
    let mut taken: BTreeMap<(&str, u32), u32> = BTreeMap::new();
    for statement in dataset.statements() {
        let (Some(def), Some((id, span))) = (statement.def, statement.id) else {
            continue;
        };
        let Some(space) = def.id else {
            continue;
        };
        let new = renumbering.get(&(space, id)).copied().unwrap_or(id);
        if let Some(other) = taken.insert((space, new), id)
            && other != id
        {
            return Err(Diagnostic::error(
                Code::DuplicateId,
                format!("{0}/{other} and {0}/{id} would both be {0}/{new}", def.name),
            )
            .label(dataset.source().name(), span, ""));
        }
    }
    Ok(())
}

/// Adds the edits of one statement: of its own id, and of the ids in its arguments and functions.
fn references(
    source: &Source,
    statement: &Statement,
    renumbering: &Renumbering,
    edits: &mut Vec<Edit>,
) {
    if let (Some(space), Some((id, span))) = (statement.def.and_then(|def| def.id), statement.id)
        && let Some(new) = renumbering.get(&(space, id))
        && *new != id
    {
        edits.push(Edit::new(span, spelled(*new, source.slice(span))));
    }
    let mut follow = |space: &'static str, number: &Number| {
        let old = number.value as u32;
        if f64::from(old) == number.value
            && let Some(new) = renumbering.get(&(space, old))
            && *new != old
        {
            edits.push(Edit::new(
                number.span,
                spelled(*new, source.slice(number.span)),
            ));
        }
    };
    for argument in &statement.arguments {
        match (&argument.value, argument.def.map(|def| def.kind)) {
            (Value::Numbers(numbers), Some(ValueKind::Reference(space))) => {
                for number in numbers {
                    follow(space, number);
                }
            }
            (Value::Function(expression), _) => {
                for (space, literal) in expression.references() {
                    follow(space, &expression.literals[literal]);
                }
            }
            _ => {}
        }
    }
}

/// Adds the edits of ID and RANGE in an ACTIVATE or DEACTIVATE command. Their id space follows from the kind of object in the same command.
fn activation(
    dataset: &Dataset,
    command: &Statement,
    renumbering: &Renumbering,
    edits: &mut Vec<Edit>,
) {
    if !matches!(command.kind(), Some("ACTIVATE" | "DEACTIVATE")) {
        return;
    }
    let space = command
        .arguments
        .iter()
        .filter(|argument| argument.value == Value::Flag)
        .filter_map(Argument::kind)
        .find_map(|kind| STATEMENTS.iter().find(|def| def.name == kind)?.id);
    let Some(space) = space else {
        return;
    };
    let new = |id: u32| renumbering.get(&(space, id)).copied().unwrap_or(id);
    for number in command.numbers("ID") {
        let old = number.value as u32;
        if f64::from(old) == number.value && new(old) != old {
            edits.push(Edit::new(number.span, new(old).to_string()));
        }
    }
    let (Some(argument), [from, to]) = (command.argument("RANGE"), command.numbers("RANGE")) else {
        return;
    };
    let all: Vec<u32> = dataset
        .statements()
        .iter()
        .filter(|statement| statement.def.is_some_and(|def| def.id == Some(space)))
        .filter_map(Statement::number)
        .collect();
    let meant = |id: &&u32| (from.value..=to.value).contains(&f64::from(**id));
    let ids: BTreeSet<u32> = all.iter().filter(meant).map(|id| new(*id)).collect();
    let unchanged = all.iter().filter(meant).all(|id| new(*id) == *id);
    let intruders = match (ids.first(), ids.last()) {
        (Some(first), Some(last)) => all
            .iter()
            .map(|id| new(*id))
            .any(|id| (first..=last).contains(&&id) && !ids.contains(&id)),
        _ => return,
    };
    if unchanged && !intruders {
        return;
    }
    let text = match (ids.first(), ids.last()) {
        (Some(first), Some(last)) if !intruders => format!("RANGE={first},{last}"),
        // Other objects have ids between the new ids, so a RANGE would include them; the ids are listed instead.
        _ => {
            let list: Vec<String> = ids.iter().map(u32::to_string).collect();
            format!("ID={}", list.join(","))
        }
    };
    edits.push(Edit::new(argument.span, text));
}

/// Formats a new id. If the old id has leading zeros, the new id gets the same width.
fn spelled(new: u32, old: &[u8]) -> String {
    let width = if old.starts_with(b"0") { old.len() } else { 0 };
    format!("{new:0width$}")
}

/// Collects the USER calls and arrays that contain numbers which may be ids. Only a number equal to an old id that changes is considered.
fn unknowable(
    source: &Source,
    statement: &Statement,
    renumbering: &Renumbering,
    places: &mut Vec<(Arc<str>, Span)>,
) {
    let changes = |number: f64| {
        renumbering
            .iter()
            .any(|((_, old), new)| f64::from(*old) == number && old != new)
    };
    for argument in &statement.arguments {
        let may_be = match &argument.value {
            Value::User(span) => source
                .text(*span)
                .split(|c: char| !(c.is_ascii_digit() || c == '.'))
                .any(|word| word.parse().is_ok_and(&changes)),
            Value::Numbers(numbers)
                if statement.kind() == Some("ARRAY") && argument.kind() == Some("NUMBERS") =>
            {
                numbers.iter().any(|number| changes(number.value))
            }
            _ => false,
        };
        if may_be {
            places.push((source.name().into(), argument.span));
        }
    }
}

/// Returns a single warning about all collected places; it shows only the first few of them.
fn one_warning(places: &[(Arc<str>, Span)]) -> Vec<Diagnostic> {
    const SHOWN: usize = 4;
    let Some((file, first)) = places.first() else {
        return Vec::new();
    };
    let message = match places.len() {
        1 => "a USER call or array may contain ids that change; its numbers are left unchanged"
            .to_string(),
        count => format!(
            "{count} USER calls or arrays may contain ids that change; their numbers are left unchanged"
        ),
    };
    let mut diagnostic =
        Diagnostic::warning(Code::UserSubroutine, message).label(file.clone(), *first, "");
    for (file, span) in places.iter().take(SHOWN).skip(1) {
        diagnostic = diagnostic.label(file.clone(), *span, "");
    }
    vec![
        diagnostic
            .help("check these numbers by hand: their meaning is defined in the user subroutine"),
    ]
}
