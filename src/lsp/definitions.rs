//! Definitions of objects in pieces of a file, as far as they affect other statements. An edit that leaves these definitions unchanged
//! affects no other statement.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use admire_syntax::pieces::Piece;
use admire_syntax::{ObjectId, Statement};

/// Hashes of the definitions in a set of pieces, keyed by object.
pub(super) struct Definitions {
    of: BTreeMap<ObjectId, Vec<u64>>,
    /// Last body in the pieces. Following markers without a PART belong to it.
    pub body: Option<ObjectId>,
}

impl Definitions {
    /// Collects the definitions in `pieces`. The body `entering` is the last body before the pieces.
    pub(crate) fn of<'p>(
        entering: Option<ObjectId>,
        pieces: impl IntoIterator<Item = &'p Arc<Piece>>,
    ) -> Self {
        let (mut of, mut body) = (BTreeMap::<ObjectId, Vec<u64>>::new(), entering);
        for piece in pieces {
            for statement in piece.statements() {
                let Some(object) = statement.object() else {
                    continue;
                };
                if is_known_body(statement) {
                    body = Some(object);
                }
                let mut hasher = DefaultHasher::new();
                piece.source().slice(statement.span).hash(&mut hasher);
                let name = statement.view_name.map(|name| piece.source().slice(name));
                name.hash(&mut hasher);
                if statement.follows_body() {
                    body.hash(&mut hasher);
                }
                of.entry(object).or_default().push(hasher.finish());
            }
        }
        Self { of, body }
    }

    /// Returns the objects whose definitions differ between `self` and `other`.
    pub(crate) fn differing(&self, other: &Self) -> Vec<ObjectId> {
        let objects: BTreeSet<&ObjectId> = self.of.keys().chain(other.of.keys()).collect();
        let differs = |object: &&ObjectId| self.of.get(*object) != other.of.get(*object);
        objects.into_iter().filter(differs).copied().collect()
    }
}

/// Returns true for a body with an id. Markers that follow such a body need not name it.
pub(super) fn is_known_body(statement: &Statement) -> bool {
    statement.carries_markers() && statement.object().is_some()
}
