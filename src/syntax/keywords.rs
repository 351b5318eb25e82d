use super::hash::QuickMap;
use crate::diagnostic::Severity;
use crate::grammar::{
    ArgumentDef, Lookup, Role, STATEMENTS, StatementDef, all_nearest, find_argument, find_statement,
};

/// Failure to find a keyword, with similar keywords for the message.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Missed {
    /// Several keywords match; the list contains them.
    Ambiguous(Vec<&'static str>),
    /// No keyword matches; the list contains the most similar keywords.
    Unknown(Vec<&'static str>),
}

impl Missed {
    /// Returns the severity with which to report the failure. If no keyword is similar, it is only a warning, because the tables of this
    /// program may lack the keyword.
    pub(crate) fn severity(&self) -> Severity {
        match self {
            Self::Unknown(near) if near.is_empty() => Severity::Warning,
            Self::Ambiguous(_) | Self::Unknown(_) => Severity::Error,
        }
    }
}

type Found<T> = Result<&'static T, Missed>;

/// Cache of keyword lookups; it saves time because decks repeat the same few spellings.
#[derive(Debug)]
pub(super) struct Keywords {
    role: Role,
    /// Cached arguments, at indices given by a hash of statement and spelling; a new entry replaces the old entry at its index.
    recent: Vec<Recent>,
    statements: QuickMap<Vec<u8>, Found<StatementDef>>,
    arguments: QuickMap<&'static str, QuickMap<Vec<u8>, Found<ArgumentDef>>>,
}

/// A cached argument: its statement, its spelling packed into an integer, and its definition.
type Recent = Option<(&'static StatementDef, u128, &'static ArgumentDef)>;

/// Number of entries in the cache of arguments; a power of two.
const PLACES: usize = 256;

/// Packs a word of up to 16 letters, digits and underscores into an integer; words that differ only in case give the same integer.
fn packed(word: &[u8]) -> Option<u128> {
    const CAPITALS: u128 = u128::from_le_bytes([0xdf; 16]);
    let mut bytes = [0; 16];
    bytes.get_mut(..word.len())?.copy_from_slice(word);
    Some(u128::from_le_bytes(bytes) & CAPITALS)
}

/// Returns the index in the cache for a spelling of an argument of a statement.
fn place(statement: &'static StatementDef, spelling: u128) -> usize {
    let mixed = (spelling ^ (spelling >> 64)) as u64 ^ std::ptr::from_ref(statement).addr() as u64;
    (mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 56) as usize % PLACES
}

/// Maximum length of words that are cached or for which similar keywords are suggested.
const LONGEST: usize = 32;
/// Maximum number of cached spellings, so that a file full of nonsense words cannot fill the memory.
const MOST: usize = 4096;

impl Keywords {
    pub(crate) fn new(role: Role) -> Self {
        Self {
            role,
            recent: vec![None; PLACES],
            statements: QuickMap::default(),
            arguments: QuickMap::default(),
        }
    }

    pub(crate) fn statement(&mut self, typed: &[u8]) -> Found<StatementDef> {
        if let Some(found) = self.statements.get(typed) {
            return found.clone();
        }
        let role = self.role;
        let found = missed(find_statement(typed, role), typed, || {
            STATEMENTS
                .iter()
                .filter(move |def| def.role == Role::Both || def.role == role)
                .map(|def| def.name)
        });
        remember(&mut self.statements, typed, &found);
        found
    }

    pub(crate) fn argument(
        &mut self,
        statement: &'static StatementDef,
        typed: &[u8],
    ) -> Found<ArgumentDef> {
        let spelling = packed(typed).map(|spelling| (place(statement, spelling), spelling));
        if let Some((place, spelling)) = spelling
            && let Some((owner, known, def)) = self.recent[place]
            && std::ptr::eq(owner, statement)
            && known == spelling
        {
            return Ok(def);
        }
        let found = self.looked_up(statement, typed);
        if let (Some((place, spelling)), Ok(def)) = (spelling, &found) {
            self.recent[place] = Some((statement, spelling, def));
        }
        found
    }

    fn looked_up(&mut self, statement: &'static StatementDef, typed: &[u8]) -> Found<ArgumentDef> {
        let known = self.arguments.entry(statement.name).or_default();
        if let Some(found) = known.get(typed) {
            return found.clone();
        }
        let found = missed(find_argument(statement, typed), typed, || {
            statement.arguments.iter().map(|def| def.name)
        });
        remember(known, typed, &found);
        found
    }
}

fn missed<T, I: Iterator<Item = &'static str>>(
    lookup: Lookup<&'static T>,
    typed: &[u8],
    names: impl FnOnce() -> I,
) -> Found<T> {
    match lookup {
        Lookup::Found(def) => Ok(def),
        Lookup::Ambiguous(names) => Err(Missed::Ambiguous(names)),
        Lookup::Unknown => Err(Missed::Unknown(match std::str::from_utf8(typed) {
            Ok(text) if text.len() <= LONGEST => all_nearest(text, names()),
            _ => Vec::new(),
        })),
    }
}

fn remember<T>(known: &mut QuickMap<Vec<u8>, Found<T>>, typed: &[u8], found: &Found<T>) {
    if typed.len() <= LONGEST && known.len() < MOST {
        known.insert(typed.to_vec(), found.clone());
    }
}
