//! Edits of a whole deck: what the commands `add`, `remove`, `renumber`, `extract` and `convert-units` do.

use std::collections::BTreeSet;
use std::sync::Arc;

use admire_session::Sources;
use admire_solver::model::{convert_units, extract};
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::renumber::{in_order, renumber};
use admire_syntax::text::{Edit, Source};
use admire_syntax::{Dataset, NewStatement};

use super::assignment::Before;
use super::deck::{Deck, sources_of, usage};
use super::error::{Error, ErrorKind};
use super::unit_words::units;

impl Deck {
    /// Adds statements, such as `MARKER/99, PART=2, QP=1,2,3`, each where others of its kind stand.
    ///
    /// # Errors
    /// When the text is no statement, the deck has one with this id, or it names what the deck has not. The deck is as before then.
    pub fn add(&mut self, text: &str) -> Result<&mut Self, Error> {
        let typed = Source::new("statement", text.as_bytes());
        let statements = NewStatement::read(&typed);
        if statements.has_errors() || statements.value.is_empty() {
            let mut sources = Sources::default();
            sources.add(typed);
            let none = Diagnostic::error(
                Code::SyntaxError,
                format!("`{text}` is not a statement that can be added"),
            );
            let found = [&statements.diagnostics[..], &[none]].concat();
            return Err(Error::new(ErrorKind::Usage, &found, &sources));
        }
        let mut after = Arc::clone(&self.read);
        for statement in &statements.value {
            if after
                .value
                .position(&statement.kind, statement.id)
                .is_some()
            {
                let id = statement.id.map_or_else(String::new, |id| format!("/{id}"));
                let message = format!("{}{id} stands in the deck already", statement.kind);
                return Err(usage(Diagnostic::error(Code::DuplicateId, message)));
            }
            let edits = after.value.add(statement);
            after = Arc::new(edited(&after.value, &edits)?);
        }
        self.become_sound(after)
    }

    /// Removes an object, or all of a pattern, or an argument: `REQUEST/*`, `BUSHING/12.PRELOAD`.
    ///
    /// # Errors
    /// When the address means nothing or one value of a list, or something else names what is removed. The deck is as before then.
    pub fn remove(&mut self, text: &str) -> Result<&mut Self, Error> {
        let mut after = Arc::clone(&self.read);
        for address in self.matching(text)? {
            if address.index.is_some() {
                let message = format!("`{text}` is one value of a list");
                let help = "statements and arguments can be removed";
                return Err(usage(
                    Diagnostic::error(Code::WrongType, message).help(help),
                ));
            }
            let edits = after.value.remove(&address);
            let edits = edits.map_err(|refused| self.refused(&refused))?;
            after = Arc::new(edited(&after.value, &edits)?);
        }
        self.become_sound(after)
    }

    /// Gives all statements of a kind, its whole keyword in capitals, the ids `first`, `first + step`, ... in their order, wherever they are
    /// named.
    ///
    /// # Errors
    /// When two statements would have the same id. The deck is as before then.
    pub fn renumber(&mut self, kind: &str, first: u32, step: u32) -> Result<&mut Self, Error> {
        let dataset = self.dataset();
        let done = renumber(dataset, &[], &in_order(dataset, kind, first, step));
        let done = done.map_err(|refused| self.refused(&refused))?;
        let after = edited(dataset, &done.value.dataset)?;
        self.become_sound(Arc::new(after))
    }

    /// The parts named, by addresses or patterns, with all that acts between them and on them; what they were attached to is ground.
    ///
    /// # Errors
    /// When a name means no part that moves, or an element needs what is not attached to the parts.
    pub fn extract(&self, parts: &[&str]) -> Result<Self, Error> {
        let dataset = self.dataset();
        let mut bodies = BTreeSet::new();
        for text in parts {
            let found = self.matching(text)?.into_iter().filter_map(|address| {
                let statement = dataset.find(&address)?;
                let moves = statement.is_body() && !statement.has("GROUND");
                statement.object().filter(|_| moves)
            });
            let before = bodies.len();
            bodies.extend(found);
            if bodies.len() == before {
                let message = format!("`{text}` is no part that moves");
                let help = "name parts, such as PART/7 or their view names";
                return Err(usage(
                    Diagnostic::error(Code::UnknownTarget, message).help(help),
                ));
            }
        }
        let (model, _) = self.model()?;
        let edits = extract(dataset, &model, &bodies).map_err(|refused| self.refused(&refused))?;
        let mut new = Self::parse(self.name(), edited(dataset, &edits.value)?.value.bytes());
        new.path = None;
        Ok(new)
    }

    /// Writes all numbers in other units: `mmks`, `mks`, `cgs`, `ips`, or words such as `meter,newton`. Command files are not changed.
    ///
    /// # Errors
    /// When a word is no unit, or a number has a meaning that no grammar tells. The deck is as before then.
    pub fn convert_units(&mut self, to: &str) -> Result<&mut Self, Error> {
        let (model, _) = self.model()?;
        let old = &model.units;
        let new = units(to, [old.force, old.mass, old.length, old.time]).map_err(usage)?;
        let converted = convert_units(self.dataset(), &model, new);
        let converted = converted.map_err(|refused| {
            Error::new(ErrorKind::Input, &refused, &sources_of(self.dataset()))
        })?;
        let after = edited(self.dataset(), &converted.value)?;
        self.become_sound(Arc::new(after))
    }

    /// Takes over a changed text, if it has no fault that it had not before.
    fn become_sound(&mut self, after: Arc<Checked<Dataset>>) -> Result<&mut Self, Error> {
        let faults = Before::of(&self.read).new_faults(&after);
        if !faults.is_empty() {
            let sources = sources_of(&after.value);
            return Err(Error::new(ErrorKind::Input, &faults, &sources));
        }
        self.read = after;
        Ok(self)
    }
}

fn edited(dataset: &Dataset, edits: &[Edit]) -> Result<Checked<Dataset>, Error> {
    let refused = |conflict: &dyn std::fmt::Display| {
        Diagnostic::error(Code::CannotWrite, conflict.to_string())
    };
    dataset
        .edited(edits)
        .map_err(|conflict| usage(refused(&conflict)))
}
