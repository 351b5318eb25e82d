use std::collections::hash_map::Entry;

use crate::model::MarkerIx;
use admire_syntax::Dataset;
use admire_syntax::grammar::StatementDef;
use admire_syntax::hash::QuickMap;

/// Lookup tables from ids to indices for the objects of a dataset.
#[derive(Clone, Debug)]
pub(super) struct Ids {
    /// Index of each object by id, for each id space. Bodies have their index in the model's list, other objects the index of their
    /// statement.
    index: QuickMap<&'static str, QuickMap<u32, usize>>,
    /// Index of each marker in the model's list by id. Kept separately, because most references are to markers.
    markers: QuickMap<u32, usize>,
    /// Whether two statements of one space have the same id.
    repeats: bool,
    /// Index of each joint in the model's list by id. Empty until the joints are lowered.
    joints: QuickMap<u32, usize>,
}

/// Id spaces of bodies, which share one list of the model.
const BODIES: [&str; 4] = ["part", "point_mass", "flex_body", "fe_part"];

/// Returns whether a statement is a PART, a POINT_MASS or a body that only real ADAMS solves.
pub(super) fn is_body(def: &StatementDef) -> bool {
    def.id.is_some_and(|space| BODIES.contains(&space))
}

impl Ids {
    /// Collects the ids of a dataset. Bodies and markers get their future index in the model's list, all other objects the index of their
    /// statement.
    pub(crate) fn of(dataset: &Dataset) -> Self {
        let mut index: QuickMap<&'static str, QuickMap<u32, usize>> = QuickMap::default();
        let mut bodies = 0;
        let mut markers = QuickMap::default();
        let mut repeats = false;
        for (at, statement) in dataset.statements().iter().enumerate() {
            let (Some(def), Some(id)) = (statement.def, statement.number()) else {
                continue;
            };
            let Some(space) = def.id else {
                continue;
            };
            let known = if space == "marker" {
                &mut markers
            } else {
                index.entry(space).or_default()
            };
            let next = if BODIES.contains(&space) {
                bodies
            } else if space == "marker" {
                known.len()
            } else {
                at
            };
            match known.entry(id) {
                Entry::Occupied(_) => repeats = true,
                Entry::Vacant(place) => {
                    place.insert(next);
                    bodies += usize::from(BODIES.contains(&space));
                }
            }
        }
        Self {
            index,
            markers,
            repeats,
            joints: QuickMap::default(),
        }
    }

    /// Returns the index of a body or marker in the model's list. For other objects, returns the index of their statement.
    pub(crate) fn index(&self, space: &str, id: u32) -> Option<usize> {
        match space {
            "marker" => self.markers.get(&id).copied(),
            space => self.index.get(space)?.get(&id).copied(),
        }
    }

    pub(crate) fn marker(&self, id: u32) -> Option<MarkerIx> {
        self.index("marker", id).map(MarkerIx)
    }

    /// Returns whether the dataset defines an object with this id in this id space.
    pub(crate) fn defines(&self, space: &str, id: u32) -> bool {
        self.index(space, id).is_some()
    }

    /// Returns whether two statements of the dataset have the same id in one id space.
    pub(crate) fn repeats(&self) -> bool {
        self.repeats
    }

    /// Returns all ids of an id space in ascending order, for suggestions.
    pub(crate) fn all(&self, space: &str) -> Vec<u32> {
        let ids = match space {
            "marker" => Some(&self.markers),
            space => self.index.get(space),
        };
        let mut all: Vec<u32> = ids.into_iter().flat_map(QuickMap::keys).copied().collect();
        all.sort_unstable();
        all
    }

    /// Returns the index of a joint in the model's list.
    pub(crate) fn joint(&self, id: u32) -> Option<usize> {
        self.joints.get(&id).copied()
    }

    /// Sets the ids of the lowered joints, in the order of the model's list.
    pub(crate) fn set_joints(&mut self, ids: impl Iterator<Item = u32>) {
        self.joints = ids.enumerate().map(|(at, id)| (id, at)).collect();
    }
}
