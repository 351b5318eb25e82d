//! What an edit does to a deck beyond the value it is about: looked at before anything is written.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnostic::{Checked, Code, Diagnostic, Severity};
use crate::syntax::lint::{self, Options};
use crate::syntax::{Argument, Dataset, Statement};

use crate::text::Edit;

use super::shell::{Exit, Shell};

/// The deck after edits of its text.
pub(super) fn edited(
    deck: &Dataset,
    edits: &[Edit],
    shell: &Shell,
) -> Result<Checked<Dataset>, Exit> {
    deck.edited(edits)
        .map_err(|conflict| shell.fail(Diagnostic::error(Code::CannotWrite, conflict.to_string())))
}

/// The errors of the reader that a deck has after an edit and had not before.
pub(super) fn new_errors<'a>(
    before: &Checked<Dataset>,
    after: &'a Checked<Dataset>,
) -> Vec<&'a Diagnostic> {
    beyond(&before.diagnostics, &after.diagnostics)
}

/// Gives up, having said why, if a deck has an error that it had not before; with `force` the errors are only told.
pub(super) fn refuse_faults(
    before: &Checked<Dataset>,
    after: &Checked<Dataset>,
    force: bool,
    shell: &Shell,
) -> Result<(), Exit> {
    let mut found: Vec<Diagnostic> = new_errors(before, after).into_iter().cloned().collect();
    found.extend(faults(&before.value, &after.value));
    shell.complain(&found);
    match found.first() {
        Some(first) if !force => Err(shell.fail(
            Diagnostic::error(
                first.code,
                "nothing is written: the deck would have a new fault",
            )
            .help("change what it concerns too, or --force"),
        )),
        _ => Ok(()),
    }
}

/// The errors `admire check` finds in the new deck and not in the old one, at the places of the new text.
fn faults(before: &Dataset, after: &Dataset) -> Vec<Diagnostic> {
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
pub(super) fn same_but_for(
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
