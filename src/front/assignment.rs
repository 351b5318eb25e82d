//! What edits of a deck are, and what they do beyond the value they are about.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnostic::{Checked, Code, Diagnostic, Severity};
use crate::grammar::{STATEMENTS, ValueKind};
use crate::syntax::lint::{self, Options};
use crate::syntax::{Address, Argument, Dataset, Statement};
use crate::text::Edit;

/// A flag is switched by true and false; a number and anything else is written as it was typed.
pub(crate) fn edits(
    dataset: &Dataset,
    address: &Address,
    value: &str,
) -> Result<Vec<Edit>, Diagnostic> {
    if address.kind == "TITLE" {
        return dataset.set_text(address, value);
    }
    if is_flag(address) {
        return match value.to_ascii_lowercase().as_str() {
            "true" => dataset.set_flag(address, true),
            "false" => dataset.set_flag(address, false),
            _ => Err(Diagnostic::error(
                Code::WrongType,
                format!("{address} is a flag, it cannot be `{value}`"),
            )
            .help("write =true or =false")),
        };
    }
    dataset
        .set_typed(address, value)
        .unwrap_or_else(|| dataset.set_text(address, value))
}

fn is_flag(address: &Address) -> bool {
    let def = STATEMENTS.iter().find(|def| def.name == address.kind);
    let argument = def.and_then(|def| {
        def.arguments
            .iter()
            .find(|argument| address.argument.as_deref() == Some(argument.name))
    });
    argument.is_some_and(|argument| argument.kind == ValueKind::Flag)
}

/// The errors of the reader that a deck has after an edit and had not before.
pub(crate) fn new_errors<'a>(
    before: &Checked<Dataset>,
    after: &'a Checked<Dataset>,
) -> Vec<&'a Diagnostic> {
    beyond(&before.diagnostics, &after.diagnostics)
}

/// The errors `admire check` finds in the new deck and not in the old one, at the places of the new text.
pub(crate) fn faults(before: &Dataset, after: &Dataset) -> Vec<Diagnostic> {
    let options = Options::default();
    let (old, new) = (lint::check(before, &options), lint::check(after, &options));
    beyond(&old, &new).into_iter().cloned().collect()
}

/// Errors of `new` that are not in `old`, whatever their places.
fn beyond<'a>(old: &[Diagnostic], new: &'a [Diagnostic]) -> Vec<&'a Diagnostic> {
    let mut known: BTreeMap<(Code, &str), usize> = BTreeMap::new();
    for diagnostic in old {
        *known
            .entry((diagnostic.code, &diagnostic.message))
            .or_default() += 1;
    }
    new.iter()
        .filter(|diagnostic| diagnostic.severity == Severity::Error)
        .filter(
            |diagnostic| match known.get_mut(&(diagnostic.code, diagnostic.message.as_str())) {
                Some(count) if *count > 0 => {
                    *count -= 1;
                    false
                }
                _ => true,
            },
        )
        .collect()
}

/// True if two decks have the same statements with the same arguments, whatever their values, but for some arguments: those of
/// the statements at `places`.
pub(crate) fn same_but_for(
    before: &Dataset,
    after: &Dataset,
    places: &BTreeSet<(usize, &str)>,
) -> bool {
    let (old, new) = (before.statements(), after.statements());
    old.len() == new.len()
        && old.iter().zip(new).enumerate().all(|(at, (old, new))| {
            let aside: Vec<&str> = places
                .range((at, "")..)
                .take_while(|(place, _)| *place == at)
                .map(|(_, argument)| *argument)
                .collect();
            old.kind() == new.kind()
                && old.number() == new.number()
                && names(old, &aside).eq(names(new, &aside))
        })
}

fn names<'a>(
    statement: &'a Statement,
    aside: &'a [&'a str],
) -> impl Iterator<Item = Option<&'static str>> + 'a {
    statement
        .arguments
        .iter()
        .map(Argument::kind)
        .filter(move |name| name.is_none_or(|name| !aside.contains(&name)))
}
