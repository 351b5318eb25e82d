//! What edits of a deck are, and what they do beyond the value they are about.

use std::collections::{BTreeMap, BTreeSet};

use sha2::{Digest, Sha256};

use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::grammar::{STATEMENTS, ValueKind};
use admire_syntax::lint::{self, Options};
use admire_syntax::text::Edit;
use admire_syntax::{Address, Dataset};

/// A flag is switched by true and false; a number and anything else is written as it was typed. `beside` are addresses that have values
/// of their own.
pub(crate) fn edits(
    dataset: &Dataset,
    address: &Address,
    value: &str,
    beside: &BTreeSet<&Address>,
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
    dataset.set_typed(address, value, beside)
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

/// The errors of the reader that a deck has after an edit and had not `before`.
pub(crate) fn new_errors<'a>(
    before: &[Diagnostic],
    after: &'a Checked<Dataset>,
) -> Vec<&'a Diagnostic> {
    beyond(before, &after.diagnostics)
}

/// What was wrong with a deck before an edit. It is kept instead of the deck, which may be large.
#[derive(Clone, Debug)]
pub(crate) struct Before {
    read: Vec<Diagnostic>,
    checked: Vec<Diagnostic>,
}

impl Before {
    /// What the reader and `admire check` find in a deck.
    pub(crate) fn of(deck: &Checked<Dataset>) -> Self {
        Self {
            read: deck.diagnostics.clone(),
            checked: lint::check(&deck.value, &Options::default()),
        }
    }

    /// The errors that reader and `admire check` find in the new deck and did not find in this one, at the places of the new text.
    pub(crate) fn new_faults(&self, after: &Checked<Dataset>) -> Vec<Diagnostic> {
        let checked = lint::check(&after.value, &Options::default());
        let of_reader = beyond(&self.read, &after.diagnostics).into_iter();
        of_reader
            .chain(beyond(&self.checked, &checked))
            .cloned()
            .collect()
    }
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

/// A digest of all statements and arguments of a deck, whatever their values, but for some arguments: those of the statements at
/// `places`. It is the same before and after an edit that changes no more than these.
pub(crate) fn outline(dataset: &Dataset, places: &BTreeSet<(usize, &str)>) -> [u8; 32] {
    let mut hash = Sha256::new();
    let mut name = |name: Option<&str>| {
        // No name of the grammar has one of these bytes.
        hash.update(name.map_or(&b"\x01"[..], str::as_bytes));
        hash.update(b"\0");
    };
    for (at, statement) in dataset.statements().iter().enumerate() {
        let aside: Vec<&str> = places
            .range((at, "")..)
            .take_while(|(place, _)| *place == at)
            .map(|(_, argument)| *argument)
            .collect();
        name(statement.kind());
        name(statement.number().map(|id| id.to_string()).as_deref());
        for argument in &statement.arguments {
            let kind = argument.kind();
            if kind.is_none_or(|kind| !aside.contains(&kind)) {
                name(kind);
            }
        }
        name(Some("\n"));
    }
    hash.finalize().into()
}
