use std::fmt;

use super::{Dataset, Statement};
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::{
    ArgumentDef, Lookup, Role, STATEMENTS, StatementDef, ValueKind, find_argument, find_statement,
    nearest,
};
use crate::text::Span;
use crate::units::Dimension;

/// Address of an object of a deck, of one of its arguments, or of one value of an argument: `SFORCE/3`, `SFORCE/3.FUNCTION`,
/// `BUSHING/12.K.2`.
///
/// An index starts at 1. In a FUNCTION argument, the index counts the literal numbers in the text of the expression: `SFORCE/3.FUNCTION.2`.
#[derive(Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Address {
    /// Full keyword of the statement in capitals; a statement without id is addressed by its keyword alone (`EQUILIBRIUM`).
    pub kind: String,
    /// Id of the object; `None` for statements without id.
    pub id: Option<u32>,
    /// Full keyword of the argument in capitals; `None` if the address refers to the whole statement.
    pub argument: Option<String>,
    /// Position among the values of the argument, from 1; `None` if the address gives no index.
    pub index: Option<usize>,
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.kind)?;
        if let Some(id) = self.id {
            write!(f, "/{id}")?;
        }
        if let Some(argument) = &self.argument {
            write!(f, ".{argument}")?;
        }
        if let Some(index) = self.index {
            write!(f, ".{index}")?;
        }
        Ok(())
    }
}

impl Address {
    /// Returns the grammar definition of the addressed argument, or `None` if the address has no argument or one that is not in the
    /// grammar.
    pub fn definition(&self) -> Option<&'static ArgumentDef> {
        let def = STATEMENTS.iter().find(|def| def.name == self.kind)?;
        let name = self.argument.as_deref()?;
        def.arguments.iter().find(|argument| argument.name == name)
    }

    /// Returns the physical dimension of the addressed value; numbers inside functions count as dimensionless.
    pub fn dimension(&self) -> Dimension {
        match self.definition() {
            Some(def) if def.kind == ValueKind::Real => {
                def.dimension_of(self.index.map_or(0, |k| k.saturating_sub(1)))
            }
            _ => Dimension::NONE,
        }
    }

    /// Returns the address of a whole statement, or `None` if its keyword is not in the grammar.
    pub fn of(statement: &Statement) -> Option<Self> {
        Some(Self {
            kind: statement.kind()?.to_string(),
            id: statement.number(),
            argument: None,
            index: None,
        })
    }

    /// Returns the address of an argument of a statement, or of one of its values if `index` (from 1) is given.
    pub fn of_argument(kind: &str, id: u32, argument: &str, index: Option<usize>) -> Self {
        Self {
            kind: kind.to_string(),
            id: Some(id),
            argument: Some(argument.to_string()),
            index,
        }
    }

    /// Builds the address of a statement or command from its definition, its id, and `rest`, the part of the address after the id: `K.2`,
    /// `K` or nothing.
    ///
    /// `text` is the whole address as typed; it is used only in messages.
    ///
    /// # Errors
    /// Returns `unknown-argument`, `ambiguous-keyword` or `bad-number`, located in a file named `address`.
    pub fn of_kind(
        def: &'static StatementDef,
        id: Option<u32>,
        rest: &str,
        text: &str,
    ) -> Result<Self, Diagnostic> {
        argument(def, id, rest, text)
    }

    /// Parses an address given in one of three forms; case is ignored.
    ///
    /// - Keyword and id: `BUSHING/12.K.2`; keywords may be abbreviated.
    /// - View name, which an `adams_view_name` comment gives: `front_arm_bushing.K.2`.
    /// - Default name of an object without a view name: `BUSHING_12.K.2`.
    ///
    /// The object must be in the dataset and the argument in the grammar, but the statement need not contain the argument.
    ///
    /// # Errors
    /// Returns `undefined-id`, `unknown-statement`, `unknown-argument`, `bad-number` or `ambiguous-keyword`, located in a file named
    /// `address`.
    pub fn parse(text: &str, dataset: &Dataset) -> Result<Self, Diagnostic> {
        let text = text.trim();
        if let Some((keyword, rest)) = text.split_once('/')
            && let Lookup::Found(def) = find_statement(keyword.trim().as_bytes(), Role::Dataset)
        {
            return with_id(def, rest, text, dataset);
        }
        if let Some(found) = by_name(text, dataset)? {
            return Ok(found);
        }
        let (head, rest) = text.split_once('.').unwrap_or((text, ""));
        if let Some((keyword, id)) = head.rsplit_once('_')
            && let Some(def) = STATEMENTS
                .iter()
                .find(|def| def.id.is_some() && def.name.eq_ignore_ascii_case(keyword))
            && id.bytes().all(|byte| byte.is_ascii_digit())
        {
            let rest = if rest.is_empty() {
                id.to_string()
            } else {
                format!("{id}.{rest}")
            };
            return with_id(def, &rest, text, dataset);
        }
        if let Lookup::Found(def) = find_statement(head.as_bytes(), Role::Dataset)
            && def.id.is_none()
        {
            return argument(def, None, rest, text);
        }
        let names: Vec<String> = dataset
            .view_names()
            .map(|(name, _)| name.to_uppercase())
            .collect();
        let near = nearest(head, names.iter().map(String::as_str));
        Err(error(
            Code::UndefinedId,
            format!("this dataset has no object {head}"),
            text,
            match near {
                Some(near) => format!("did you mean {near}?"),
                None => "write KEYWORD/id.ARGUMENT.index, such as BUSHING/12.K.2, or a view name for KEYWORD/id".into(),
            },
        ))
    }
}

/// Parses the part of an address after the slash: `12.K.2` of `BUSHING/12.K.2`.
fn with_id(
    def: &'static StatementDef,
    rest: &str,
    text: &str,
    dataset: &Dataset,
) -> Result<Address, Diagnostic> {
    let (id, rest) = rest.split_once('.').unwrap_or((rest, ""));
    let id = id.trim();
    if def.id.is_none() && id.is_empty() {
        return argument(def, None, rest, text);
    }
    let Ok(id) = id.parse::<u32>() else {
        return Err(error(
            Code::BadNumber,
            format!("{id} is not a valid id of {}", def.name),
            text,
            format!("write {}/id", def.name),
        ));
    };
    if dataset.statement(def.name, Some(id)).is_none() {
        let ids: Vec<String> = dataset
            .statements()
            .iter()
            .filter(|statement| statement.kind() == Some(def.name))
            .filter_map(|statement| Some(statement.number()?.to_string()))
            .collect();
        let near = nearest(&id.to_string(), ids.iter().map(String::as_str));
        return Err(error(
            Code::UndefinedId,
            format!("{}/{id} is not in this dataset", def.name),
            text,
            match (near, ids.as_slice()) {
                (Some(near), _) => format!("did you mean {}/{near}?", def.name),
                (None, []) => format!("this dataset has no {}", def.name),
                (None, [first, ..]) => format!("the first one is {}/{first}", def.name),
            },
        ));
    }
    argument(def, Some(id), rest, text)
}

/// Resolves an address that begins with a view name. If several view names match, the longest is used. Returns `None` if no view name
/// matches.
fn by_name(text: &str, dataset: &Dataset) -> Result<Option<Address>, Diagnostic> {
    let ends = std::iter::once(text.len()).chain(text.rmatch_indices('.').map(|(at, _)| at));
    for end in ends.take(8) {
        let rest = text[end..].trim_start_matches('.');
        let mut found = Vec::new();
        let mut refused = None;
        for at in dataset.named(&text[..end]) {
            let statement = &dataset.statements()[*at];
            let Some(def) = statement.def else {
                continue;
            };
            match argument(def, statement.number(), rest, text) {
                Ok(address) => found.push(address),
                Err(diagnostic) => refused = Some(diagnostic),
            }
        }
        // If several objects share the name, the object whose statement contains the argument is chosen.
        if found.len() > 1 {
            let written: Vec<Address> = found
                .iter()
                .filter(|address| {
                    address.argument.as_ref().is_some_and(|name| {
                        dataset
                            .find(address)
                            .is_some_and(|statement| statement.has(name))
                    })
                })
                .cloned()
                .collect();
            if written.len() == 1 {
                found = written;
            }
        }
        match (found.as_slice(), refused) {
            ([one], _) => return Ok(Some(one.clone())),
            ([], Some(diagnostic)) => return Err(diagnostic),
            ([], None) => {}
            (several, _) => {
                let all: Vec<String> = several.iter().map(Address::to_string).collect();
                return Err(error(
                    Code::AmbiguousKeyword,
                    format!("{} objects are called {}", several.len(), &text[..end]),
                    text,
                    format!("write one of {}", all.join(", ")),
                ));
            }
        }
    }
    Ok(None)
}

/// Parses the part of an address after the id: `K.2`, `K` or nothing.
pub(super) fn argument(
    def: &'static StatementDef,
    id: Option<u32>,
    rest: &str,
    text: &str,
) -> Result<Address, Diagnostic> {
    let mut address = Address {
        kind: def.name.to_string(),
        id,
        argument: None,
        index: None,
    };
    if rest.is_empty() {
        return Ok(address);
    }
    let (name, index) = match rest.split_once('.') {
        Some((name, index)) => (name.trim(), Some(index.trim())),
        None => (rest.trim(), None),
    };
    address.argument = match find_argument(def, name.as_bytes()) {
        Lookup::Found(argument) => Some(argument.name.to_string()),
        Lookup::Ambiguous(names) => {
            return Err(error(
                Code::AmbiguousKeyword,
                format!(
                    "{name} is the beginning of several arguments of {}",
                    def.name
                ),
                text,
                format!("write one of {}", names.join(", ")),
            ));
        }
        Lookup::Unknown => {
            let names = || def.arguments.iter().map(|argument| argument.name);
            return Err(error(
                Code::UnknownArgument,
                format!("{} has no argument {name}", def.name),
                text,
                match nearest(name, names()) {
                    Some(near) => format!("did you mean {near}?"),
                    None => format!(
                        "its arguments are {}",
                        names().collect::<Vec<_>>().join(", ")
                    ),
                },
            ));
        }
    };
    if let Some(index) = index {
        match index.parse::<usize>() {
            Ok(number) if number > 0 => address.index = Some(number),
            _ => {
                return Err(error(
                    Code::BadNumber,
                    format!("{index} is not a valid index"),
                    text,
                    "values are counted from 1".into(),
                ));
            }
        }
    }
    Ok(address)
}

fn error(code: Code, message: String, text: &str, help: String) -> Diagnostic {
    Diagnostic::error(code, message)
        .label("address", Span::new(0, text.len()), "")
        .help(help)
}
