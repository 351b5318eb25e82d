//! Index of the objects of a file that is split into pieces: which statement defines each object, and which pieces refer to it.

use std::collections::BTreeSet;

use super::hash::QuickMap;
use super::pieces::Piece;
use super::{Argument, ObjectId, Reference, Statement};

/// Location of a statement in a file that is split into pieces: the key of its piece, and its index in that piece.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Place {
    /// Key of the piece that contains the statement.
    pub piece: u32,
    /// Index of the statement in the piece.
    pub at: usize,
}

/// Index that lists, for each object, its definitions and the pieces that refer to it. The index is independent of the order of the pieces.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Catalogue {
    defined: QuickMap<ObjectId, Vec<Place>>,
    referring: QuickMap<ObjectId, BTreeSet<u32>>,
}

impl Catalogue {
    /// Adds the objects and references of a piece to the index.
    pub fn add(&mut self, piece: &Piece) {
        let key = piece.key();
        for (at, statement) in piece.statements().iter().enumerate() {
            let place = Place { piece: key, at };
            if let Some(object) = statement.object() {
                self.defined.entry(object).or_default().push(place);
            }
            for reference in references(statement) {
                let object = (reference.space, reference.id);
                self.referring.entry(object).or_default().insert(key);
            }
        }
    }

    /// Removes the objects and references of a piece from the index. The piece must have been added before.
    pub fn remove(&mut self, piece: &Piece) {
        let key = piece.key();
        for statement in piece.statements() {
            if let Some(object) = statement.object() {
                forget(&mut self.defined, &object, key);
            }
            for reference in references(statement) {
                let object = (reference.space, reference.id);
                if let Some(pieces) = self.referring.get_mut(&object) {
                    pieces.remove(&key);
                    if pieces.is_empty() {
                        self.referring.remove(&object);
                    }
                }
            }
        }
    }

    /// Returns the locations of the statements that define an object, in no particular order.
    pub fn definitions(&self, object: ObjectId) -> &[Place] {
        self.defined.get(&object).map_or(&[], Vec::as_slice)
    }

    /// Iterates over the keys of the pieces that refer to an object.
    pub fn referring(&self, object: ObjectId) -> impl Iterator<Item = u32> + '_ {
        self.referring.get(&object).into_iter().flatten().copied()
    }

    /// Iterates over all defined objects and their definitions, in no particular order.
    pub fn objects(&self) -> impl Iterator<Item = (ObjectId, &[Place])> {
        self.defined
            .iter()
            .map(|(object, places)| (*object, places.as_slice()))
    }
}

/// Returns all references of a statement to objects, including references inside functions.
pub fn references(statement: &Statement) -> impl Iterator<Item = Reference> + '_ {
    statement.arguments.iter().flat_map(Argument::references)
}

fn forget<K: std::hash::Hash + Eq>(map: &mut QuickMap<K, Vec<Place>>, key: &K, piece: u32) {
    if let Some(places) = map.get_mut(key) {
        places.retain(|place| place.piece != piece);
        if places.is_empty() {
            map.remove(key);
        }
    }
}
