use std::sync::OnceLock;

use super::{ArgumentDef, Choice, FUNCTIONS, FunctionDef, Role, STATEMENTS, StatementDef};

/// Result of looking up a typed keyword.
#[derive(Clone, Debug, PartialEq)]
pub enum Lookup<T> {
    /// Exactly one keyword matches.
    Found(T),
    /// Several keywords match. If the typed word is a legal abbreviation of several of them, only these are listed; otherwise all are.
    Ambiguous(Vec<&'static str>),
    /// No keyword matches.
    Unknown,
}

impl<T> Lookup<T> {
    /// Returns the matching keyword, or `None` if several keywords match or none does.
    pub fn found(self) -> Option<T> {
        match self {
            Self::Found(value) => Some(value),
            Self::Ambiguous(_) | Self::Unknown => None,
        }
    }
}

/// Finds the keyword that a typed word abbreviates; case is ignored (guide/formats.md 1.5).
///
/// An exact match wins. Otherwise the typed word matches if it is the beginning of exactly one keyword, or a legal abbreviation (at least
/// as long as the shortest one) of exactly one keyword. A word longer than its keyword also matches if it begins with exactly one whole
/// keyword of five or more letters: `TRANSLATIONAL` for `TRANSLATION`.
fn resolve<T: Copy>(
    typed: &[u8],
    candidates: impl Iterator<Item = (T, &'static str, usize)> + Clone,
) -> Lookup<T> {
    let begins = |name: &str| {
        name.len() >= typed.len() && name.as_bytes()[..typed.len()].eq_ignore_ascii_case(typed)
    };
    if typed.is_empty() {
        return Lookup::Unknown;
    }
    if let Some(hit) = candidates
        .clone()
        .find(|(_, name, _)| name.as_bytes().eq_ignore_ascii_case(typed))
    {
        return Lookup::Found(hit.0);
    }
    let prefixed: Vec<_> = candidates
        .clone()
        .filter(|(_, name, _)| begins(name))
        .collect();
    let reached: Vec<_> = prefixed
        .iter()
        .filter(|(_, _, minimum)| typed.len() >= *minimum)
        .collect();
    match (reached.as_slice(), prefixed.as_slice()) {
        ([one], _) => Lookup::Found(one.0),
        ([], [one]) => Lookup::Found(one.0),
        ([], []) => {
            let longer: Vec<_> = candidates
                .filter(|(_, name, _)| {
                    name.len() >= 5
                        && typed.len() > name.len()
                        && typed[..name.len()].eq_ignore_ascii_case(name.as_bytes())
                })
                .collect();
            match longer.as_slice() {
                [one] => Lookup::Found(one.0),
                _ => Lookup::Unknown,
            }
        }
        (several, all) => {
            let shown = if several.is_empty() {
                all.iter().map(|c| c.1).collect()
            } else {
                several.iter().map(|c| c.1).collect()
            };
            Lookup::Ambiguous(shown)
        }
    }
}

/// Finds the definition of a statement (`file` is a dataset) or of a command (`file` is a command file) from its typed keyword.
pub fn find_statement(typed: &[u8], file: Role) -> Lookup<&'static StatementDef> {
    let here = move |def: &&'static StatementDef| {
        file == Role::Both || def.role == Role::Both || def.role == file
    };
    resolve(
        typed,
        STATEMENTS
            .iter()
            .filter(here)
            .map(|def| (def, def.name, def.minimum)),
    )
}

/// Returns the statement or command with this full keyword in capitals.
pub fn statement(name: &str) -> Option<&'static StatementDef> {
    STATEMENTS.iter().find(|def| def.name == name)
}

/// Finds the argument of a statement from its typed keyword.
pub fn find_argument(
    statement: &'static StatementDef,
    typed: &[u8],
) -> Lookup<&'static ArgumentDef> {
    resolve(
        typed,
        statement
            .arguments
            .iter()
            .map(|def| (def, def.name, def.minimum)),
    )
}

/// Finds the choice that a typed word denotes or abbreviates.
pub(crate) fn find_choice(choices: &'static [Choice], typed: &[u8]) -> Lookup<&'static Choice> {
    resolve(
        typed,
        choices
            .iter()
            .map(|choice| (choice, choice.name, choice.minimum)),
    )
}

/// Returns the function with this full name; case is ignored.
pub fn find_function(typed: &[u8]) -> Option<&'static FunctionDef> {
    static BY_NAME: OnceLock<Vec<&'static FunctionDef>> = OnceLock::new();
    let by_name = BY_NAME.get_or_init(|| {
        let mut all: Vec<&'static FunctionDef> = FUNCTIONS.iter().collect();
        all.sort_unstable_by_key(|def| def.name);
        all
    });
    let upper = || typed.iter().map(u8::to_ascii_uppercase);
    let found = by_name.binary_search_by(|def| def.name.bytes().cmp(upper()));
    found.ok().map(|at| by_name[at])
}

/// Returns the name with the smallest edit distance to the typed text, if it is close enough to be the intended one.
pub fn nearest<'a>(typed: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    all_nearest(typed, names).first().copied()
}

/// Returns all names at the smallest edit distance to the typed text, in alphabetical order; empty if no name is close enough.
pub(crate) fn all_nearest<'a>(typed: &str, names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let typed = typed.to_ascii_uppercase();
    if typed.is_empty() {
        return Vec::new();
    }
    let limit = (typed.len() / 3).max(1);
    let mut near: Vec<(usize, &str)> = names
        // Words of very different length are skipped, so that no distances are computed for a word of a million letters.
        .filter(|name| name.len().abs_diff(typed.len()) <= limit)
        .map(|name| (distance(typed.as_bytes(), name.as_bytes()), name))
        .filter(|(d, _)| *d <= limit)
        .collect();
    near.sort_unstable();
    near.dedup();
    let least = near.first().map(|(d, _)| *d);
    near.into_iter()
        .filter(|(d, _)| Some(*d) == least)
        .map(|(_, name)| name)
        .collect()
}

/// Computes the optimal string alignment distance: the least number of insertions, deletions, replacements and swaps of neighbours.
fn distance(a: &[u8], b: &[u8]) -> usize {
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            rows[i][j] = if i == 0 || j == 0 {
                i + j
            } else {
                let same = usize::from(a[i - 1] != b[j - 1]);
                let mut best = (rows[i - 1][j] + 1)
                    .min(rows[i][j - 1] + 1)
                    .min(rows[i - 1][j - 1] + same);
                if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                    best = best.min(rows[i - 2][j - 2] + 1);
                }
                best
            };
        }
    }
    rows[a.len()][b.len()]
}
