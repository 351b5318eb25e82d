use super::hash::QuickMap;
use crate::diagnostic::Severity;
use crate::grammar::{
    ArgumentDef, Lookup, Role, STATEMENTS, StatementDef, find_argument, find_statement, nearest,
};

/// A keyword that was not found: what it could be, for the message.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Missed {
    /// Several keywords begin like this.
    Ambiguous(Vec<&'static str>),
    /// None does; the nearest one.
    Unknown(Option<&'static str>),
}

impl Missed {
    /// How bad it is: what is ambiguous may have been meant.
    pub fn severity(&self) -> Severity {
        match self {
            Self::Ambiguous(_) => Severity::Error,
            Self::Unknown(_) => Severity::Warning,
        }
    }
}

type Found<T> = Result<&'static T, Missed>;

/// Keywords looked up so far: decks spell the same few again and again.
#[derive(Debug)]
pub(super) struct Keywords {
    role: Role,
    statements: QuickMap<Vec<u8>, Found<StatementDef>>,
    arguments: QuickMap<&'static str, QuickMap<Vec<u8>, Found<ArgumentDef>>>,
}

/// Longer words are never keywords worth remembering, or worth a suggestion.
const LONGEST: usize = 32;
/// A file of nonsense shall not fill the memory.
const MOST: usize = 4096;

impl Keywords {
    pub fn new(role: Role) -> Self {
        Self {
            role,
            statements: QuickMap::default(),
            arguments: QuickMap::default(),
        }
    }

    pub fn statement(&mut self, typed: &[u8]) -> Found<StatementDef> {
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

    pub fn argument(
        &mut self,
        statement: &'static StatementDef,
        typed: &[u8],
    ) -> Found<ArgumentDef> {
        // Most decks write whole keywords, and those win whatever else begins like them.
        if let Some(exact) = statement.arguments.iter().find(|def| {
            def.name.len() == typed.len() && def.name.as_bytes().eq_ignore_ascii_case(typed)
        }) {
            return Ok(exact);
        }
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
            Ok(text) if text.len() <= LONGEST => nearest(text, names()),
            _ => None,
        })),
    }
}

fn remember<T>(known: &mut QuickMap<Vec<u8>, Found<T>>, typed: &[u8], found: &Found<T>) {
    if typed.len() <= LONGEST && known.len() < MOST {
        known.insert(typed.to_vec(), found.clone());
    }
}
