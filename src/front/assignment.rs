//! Edits for assignments to a deck, and checks that they change nothing else.

use std::collections::{BTreeMap, BTreeSet};

use sha2::{Digest, Sha256};

use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::grammar::{STATEMENTS, ValueKind};
use admire_syntax::lint::{self, Options};
use admire_syntax::text::Edit;
use admire_syntax::{Address, Dataset};

/// Creates the edits that assign a value to an address. A flag is set by `true` or `false`; any other value is written as typed. `beside`
/// contains the addresses that get a value in the same change.
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
                format!("{address} is a flag, so its value cannot be `{value}`"),
            )
            .help("write true or false")),
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

/// Returns the parser errors of a deck after an edit that are not among the diagnostics `before` the edit.
pub(crate) fn new_errors<'a>(
    before: &[Diagnostic],
    after: &'a Checked<Dataset>,
) -> Vec<&'a Diagnostic> {
    beyond(before, &after.diagnostics)
}

/// Diagnostics of a deck before an edit. They are kept in place of the deck, which may be large.
#[derive(Clone, Debug)]
pub(crate) struct Before {
    read: Vec<Diagnostic>,
    checked: Vec<Diagnostic>,
}

impl Before {
    /// Collects the diagnostics of the parser and of `admire check`.
    pub(crate) fn of(deck: &Checked<Dataset>) -> Self {
        Self {
            read: deck.diagnostics.clone(),
            checked: lint::check(&deck.value, &Options::default()),
        }
    }

    /// Returns the errors of the parser and of `admire check` that are new in the changed deck, with their places in the new text.
    pub(crate) fn new_faults(&self, after: &Checked<Dataset>) -> Vec<Diagnostic> {
        let checked = lint::check(&after.value, &Options::default());
        let of_reader = beyond(&self.read, &after.diagnostics).into_iter();
        of_reader
            .chain(beyond(&self.checked, &checked))
            .cloned()
            .collect()
    }
}

/// Returns the errors in `new` that are not in `old`, regardless of their places.
pub(crate) fn beyond<'a>(old: &[Diagnostic], new: &'a [Diagnostic]) -> Vec<&'a Diagnostic> {
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

/// Computes a digest of the names of all statements and arguments in a deck, independent of their values. `places` lists arguments, each
/// with the index of its statement, that are left out of the digest. An edit that changes only those arguments leaves the digest unchanged.
pub(crate) fn structure_digest(dataset: &Dataset, places: &BTreeSet<(usize, &str)>) -> [u8; 32] {
    let mut hash = Sha256::new();
    let mut name = |name: Option<&str>| {
        // No name in the grammar contains one of these bytes.
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
