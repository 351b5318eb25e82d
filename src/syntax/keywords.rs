use super::hash::QuickMap;
use crate::diagnostic::Severity;
use crate::grammar::{
    ArgumentDef, Lookup, Role, STATEMENTS, StatementDef, all_nearest, find_argument, find_statement,
};

/// A keyword that was not found: what it could be, for the message.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Missed {
    /// Several keywords begin like this.
    Ambiguous(Vec<&'static str>),
    /// None does; the nearest ones.
    Unknown(Vec<&'static str>),
}

impl Missed {
    /// How bad it is at most: a keyword nothing comes near to may be one that this program lacks.
    pub(crate) fn severity(&self) -> Severity {
        match self {
            Self::Unknown(near) if near.is_empty() => Severity::Warning,
            Self::Ambiguous(_) | Self::Unknown(_) => Severity::Error,
        }
    }
}

type Found<T> = Result<&'static T, Missed>;

/// Keywords looked up so far: decks spell the same few again and again.
#[derive(Debug)]
pub(super) struct Keywords {
    role: Role,
    /// The arguments that were found, each at a place that follows from statement and spelling: the latest one stays.
    recent: Vec<Recent>,
    statements: QuickMap<Vec<u8>, Found<StatementDef>>,
    arguments: QuickMap<&'static str, QuickMap<Vec<u8>, Found<ArgumentDef>>>,
}

/// An argument that was found: its statement, how it was spelled, what it is.
type Recent = Option<(&'static StatementDef, u128, &'static ArgumentDef)>;

/// How many places there are for those; a power of two.
const PLACES: usize = 256;

/// A word of up to 16 letters, digits and underscores as one number, the same in capitals and small letters.
fn packed(word: &[u8]) -> Option<u128> {
    const CAPITALS: u128 = u128::from_le_bytes([0xdf; 16]);
    let mut bytes = [0; 16];
    bytes.get_mut(..word.len())?.copy_from_slice(word);
    Some(u128::from_le_bytes(bytes) & CAPITALS)
}

/// Where a spelling has its place among those of a statement.
fn place(statement: &'static StatementDef, spelling: u128) -> usize {
    let mixed = (spelling ^ (spelling >> 64)) as u64 ^ std::ptr::from_ref(statement).addr() as u64;
    (mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 56) as usize % PLACES
}

/// Longer words are never keywords worth remembering, or worth a suggestion.
const LONGEST: usize = 32;
/// A file of nonsense shall not fill the memory.
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
