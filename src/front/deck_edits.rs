//! Edits of a whole deck: the operations of the commands `add`, `remove`, `renumber`, `extract` and `convert-units`.

use std::collections::BTreeSet;
use std::sync::Arc;

use admire_session::Sources;
use admire_solver::model::{convert_units, extract};
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::grammar::{Lookup, Role, find_statement};
use admire_syntax::renumber::{in_order, renumber};
use admire_syntax::text::{Edit, Source};
use admire_syntax::{Address, Dataset, NewStatement, ObjectId};

use super::assignment::Before;
use super::deck::{Deck, sources_of, usage};
use super::error::{Error, ErrorKind};
use super::unit_words::units;

impl Deck {
    /// Adds statements, such as `MARKER/99, PART=2, QP=1,2,3`. Each is inserted after the existing statements of its kind.
    ///
    /// # Errors
    /// When the text is not a statement, when its id is taken, or when it refers to an object that is missing in the deck. The deck is then
    /// unchanged.
    pub fn add(&mut self, text: &str) -> Result<&mut Self, Error> {
        let typed = Source::new("statement", text.as_bytes());
        let statements = NewStatement::read(&typed);
        if statements.has_errors() || statements.value.is_empty() {
            let mut sources = Sources::default();
            sources.add(typed);
            let found = [&statements.diagnostics[..], &[no_statement(text)]].concat();
            return Err(Error::new(ErrorKind::Usage, &found, &sources));
        }
        let after = with_statements(&self.read, &statements.value).map_err(usage)?;
        self.replace_by(after)
    }

    /// Removes an object, all objects that match a pattern, or an argument. Examples: `REQUEST/*`, `BUSHING/12.PRELOAD`.
    ///
    /// # Errors
    /// When the address does not exist, when it is one value of a list, or when another statement refers to the object. The deck is then
    /// unchanged.
    pub fn remove(&mut self, text: &str) -> Result<&mut Self, Error> {
        let mut after = (*self.read).clone();
        for address in self.matching(text)? {
            let edits = removal(&after.value, &address, text);
            let edits = edits.map_err(|refused| self.refused(&refused))?;
            after = edited(&after.value, &edits).map_err(usage)?;
        }
        self.replace_by(after)
    }

    /// Gives the statements of a kind, such as `MARKER`, the ids `first`, `first + step`, ... in the order of the deck, and updates all
    /// references.
    ///
    /// # Errors
    /// When the kind has no ids, or two statements would get the same id. The deck is then unchanged.
    pub fn renumber(&mut self, kind: &str, first: u32, step: u32) -> Result<&mut Self, Error> {
        let Some(kind) = kind_with_ids(kind) else {
            let message = format!("`{kind}` is not a kind of statement with an id");
            return Err(usage(Diagnostic::error(Code::UnknownStatement, message)));
        };
        let dataset = self.dataset();
        let done = renumber(dataset, &[], &in_order(dataset, kind, first, step));
        let done = done.map_err(|refused| self.refused(&refused))?;
        let after = edited(dataset, &done.value.dataset).map_err(usage)?;
        self.replace_by(after)
    }

    /// Returns a deck of the named parts, given by addresses or patterns, with the elements between these parts and between them and
    /// ground. All other parts become ground.
    ///
    /// # Errors
    /// When a name is not a moving part, or an element refers to something that would be missing.
    pub fn extract(&self, parts: &[&str]) -> Result<Self, Error> {
        let dataset = self.dataset();
        let mut bodies = BTreeSet::new();
        for text in parts {
            bodies.extend(moving_parts(dataset, text).map_err(usage)?);
        }
        let (model, _) = self.model()?;
        let edits = extract(dataset, &model, &bodies).map_err(|refused| self.refused(&refused))?;
        let after = edited(dataset, &edits.value).map_err(usage)?;
        Ok(Self::parse(self.name(), after.value.bytes()))
    }

    /// Converts all numbers of the deck to other units. The units are `mmks`, `mks`, `cgs`, `ips`, or words such as `meter,newton`. Command
    /// files are not converted.
    ///
    /// # Errors
    /// When a word is not a unit, or when the dimension of a number is unknown. The deck is then unchanged.
    pub fn convert_units(&mut self, to: &str) -> Result<&mut Self, Error> {
        let (model, _) = self.model()?;
        let old = &model.units;
        let new = units(to, [old.force, old.mass, old.length, old.time]).map_err(usage)?;
        let converted = convert_units(self.dataset(), &model, new);
        let converted = converted.map_err(|refused| {
            Error::new(ErrorKind::Input, &refused, &sources_of(self.dataset()))
        })?;
        let after = edited(self.dataset(), &converted.value).map_err(usage)?;
        self.replace_by(after)
    }

    /// Replaces the text of the deck, unless the new text has a fault that the old text does not have.
    fn replace_by(&mut self, after: Checked<Dataset>) -> Result<&mut Self, Error> {
        let faults = Before::of(&self.read).new_faults(&after);
        if !faults.is_empty() {
            let sources = sources_of(&after.value);
            return Err(Error::new(ErrorKind::Input, &faults, &sources));
        }
        self.read = Arc::new(after);
        Ok(self)
    }
}

/// Applies edits to a dataset.
pub(crate) fn edited(dataset: &Dataset, edits: &[Edit]) -> Result<Checked<Dataset>, Diagnostic> {
    let refused = |why: String| Diagnostic::error(Code::CannotWrite, why);
    let after = dataset.edited(edits);
    after.map_err(|conflict| refused(conflict.to_string()))
}

/// Creates the diagnostic for a text that is not a statement.
pub(crate) fn no_statement(text: &str) -> Diagnostic {
    let message = format!("`{text}` is not a statement that can be added");
    Diagnostic::error(Code::SyntaxError, message)
        .help("write a whole statement, such as `MARKER/99, PART=2, QP=1,2,3`")
}

/// Adds statements to a dataset; it is an error if an id is already taken.
pub(crate) fn with_statements(
    before: &Checked<Dataset>,
    statements: &[NewStatement],
) -> Result<Checked<Dataset>, Diagnostic> {
    let mut after = before.clone();
    for statement in statements {
        let taken = after.value.position(&statement.kind, statement.id);
        if taken.is_some() {
            let id = statement.id.map_or_else(String::new, |id| format!("/{id}"));
            let message = format!("the deck already has {}{id}", statement.kind);
            let help = match statement.id {
                Some(_) => "give the new statement another id",
                None => "change the existing statement instead",
            };
            return Err(Diagnostic::error(Code::DuplicateId, message).help(help));
        }
        let edits = after.value.add(statement);
        after = edited(&after.value, &edits)?;
    }
    Ok(after)
}

/// Creates the edits that remove a statement or an argument. `text` is the address as the user typed it.
pub(crate) fn removal(
    dataset: &Dataset,
    address: &Address,
    text: &str,
) -> Result<Vec<Edit>, Diagnostic> {
    if address.index.is_none() {
        return dataset.remove(address);
    }
    let message = format!("`{text}` is one value of a list");
    let help = "only statements and arguments can be removed";
    Err(Diagnostic::error(Code::WrongType, message).help(help))
}

/// Returns the moving parts that match a pattern; it is an error if there are none.
pub(crate) fn moving_parts(dataset: &Dataset, text: &str) -> Result<Vec<ObjectId>, Diagnostic> {
    let addresses = Address::matching(text, dataset).map_err(|mut refused| {
        refused.labels.clear();
        refused.message = format!("`{text}`: {}", refused.message);
        refused
    })?;
    let body = |address: Address| {
        let statement = dataset.find(&address)?;
        let moves = statement.is_body() && !statement.has("GROUND");
        statement.object().filter(|_| moves)
    };
    let found: Vec<ObjectId> = addresses.into_iter().filter_map(body).collect();
    if found.is_empty() {
        let message = format!("`{text}` is not a moving part");
        let help = "name parts, such as PART/7 or their view names";
        return Err(Diagnostic::error(Code::UnknownTarget, message).help(help));
    }
    Ok(found)
}

/// Returns the full keyword of a statement kind that has ids, from the keyword or its abbreviation. `None` for any other word, such as the
/// name `MARKER_3`.
pub(crate) fn kind_with_ids(word: &str) -> Option<&'static str> {
    match find_statement(word.as_bytes(), Role::Dataset) {
        Lookup::Found(def) if def.id.is_some() && word.len() <= def.name.len() => Some(def.name),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shipped() -> Deck {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        Deck::open(folder.join("corpus/pseudo-mcpherson/model.adm")).unwrap()
    }

    #[test]
    fn statements_are_added_and_removed_and_faults_are_refused() {
        let mut deck = shipped();
        deck.add("MARKER/900, PART=4, QP=0, 0, 100").unwrap();
        assert_eq!(deck.number("MARKER/900.QP.3").unwrap(), 100.0);
        let before = deck.bytes().to_vec();
        // These edits must fail: the same statement again, an undefined reference, a text that is not a statement, a part with markers, and
        // one value of a list.
        assert!(deck.add("MARKER/900, PART=4").is_err());
        assert!(deck.add("REQUEST/900, DISPLACEMENT, I=901, J=2").is_err());
        assert!(deck.add("not a statement").is_err());
        assert!(deck.remove("PART/4").is_err());
        assert!(deck.remove("MARKER/900.QP.3").is_err());
        assert_eq!(deck.bytes(), before);
        deck.remove("MARKER/900").unwrap();
        assert!(deck.number("MARKER/900.QP.3").is_err());
    }

    /// Both systems measure in newtons, kilograms and seconds. A length in metres is a thousandth of the length in millimetres.
    #[test]
    fn other_ids_and_units_are_the_same_model() {
        let place = |deck: &Deck| {
            let run = deck.solve().unwrap();
            *run.column("KNUCKLE.X").unwrap().last().unwrap()
        };
        let mut deck = shipped();
        let millimetres = place(&deck);
        deck.renumber("MARKER", 1001, 1).unwrap();
        assert!((place(&deck) - millimetres).abs() < 1e-9);
        assert!(deck.renumber("KNUCKLE", 1, 1).is_err());
        assert_eq!(deck.number("SPRINGDAMPER/1.K").unwrap(), 60.0);
        deck.convert_units("mks").unwrap();
        assert_eq!(deck.number("SPRINGDAMPER/1.K").unwrap(), 60_000.0);
        assert!((1e3 * place(&deck) - millimetres).abs() < 1e-4);
        assert!(deck.convert_units("furlong").is_err());
    }

    #[test]
    fn a_part_is_extracted_with_what_holds_it() {
        let part = shipped().extract(&["PART/6"]).unwrap();
        assert!(part.get("PART/6").is_ok() && part.get("PART/3").is_err());
        assert!(part.get("JOINT/5").is_ok());
        assert!(shipped().extract(&["PART/1"]).is_err());
    }
}
