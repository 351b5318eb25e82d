use std::collections::hash_map::Entry;

use crate::model::{MarkerIx, Model, PartKind};
use crate::syntax::Dataset;
use crate::syntax::hash::QuickMap;

/// Where the objects that others refer to are.
pub(super) enum Ids<'a> {
    /// While a dataset is lowered: constant-time look-up.
    Dataset {
        /// The dataset, for what the model does not keep (MATRIX).
        dataset: &'a Dataset,
        /// Index into the model's list by id, for each id space.
        index: QuickMap<&'static str, QuickMap<u32, usize>>,
        /// The same for markers, which most references are to.
        markers: QuickMap<u32, usize>,
        /// True if two statements of one space have the same id.
        repeats: bool,
        /// Places of the joints in the model's list, once they are lowered.
        joints: QuickMap<u32, usize>,
    },
    /// While a command redefines an object of a finished model.
    Model(&'a Model),
}

/// The id spaces of bodies: they share one list of the model.
pub(super) const BODIES: [&str; 4] = ["part", "point_mass", "flex_body", "fe_part"];

impl<'a> Ids<'a> {
    /// The ids of a dataset: bodies and markers get the index they will have, everything else the index of its statement.
    pub fn of(dataset: &'a Dataset) -> Self {
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
        Self::Dataset {
            dataset,
            index,
            markers,
            repeats,
            joints: QuickMap::default(),
        }
    }

    /// Index of a body or a marker in the model's list; of the statement for the rest of a dataset.
    pub fn index(&self, space: &'static str, id: u32) -> Option<usize> {
        match self {
            Self::Dataset { markers, .. } if space == "marker" => markers.get(&id).copied(),
            Self::Dataset { index, .. } => index.get(space)?.get(&id).copied(),
            Self::Model(model) => match space {
                "marker" => model.marker(id).map(|marker| marker.0),
                space => model.parts.iter().position(|part| {
                    part.header.id == id
                        && match part.kind {
                            PartKind::Ground | PartKind::Rigid => space == "part",
                            PartKind::PointMass => space == "point_mass",
                            PartKind::External => space == "flex_body" || space == "fe_part",
                        }
                }),
            },
        }
    }

    pub fn marker(&self, id: u32) -> Option<MarkerIx> {
        self.index("marker", id).map(MarkerIx)
    }

    /// True if an object of this id space has the id. A space may hold several (`force` holds all `force.*`).
    pub fn defines(&self, space: &str, id: u32) -> bool {
        match self {
            Self::Dataset { markers, .. } if space == "marker" => markers.contains_key(&id),
            Self::Dataset { index, .. } => {
                let has = |ids: &QuickMap<u32, usize>| ids.contains_key(&id);
                index.get(space).is_some_and(has)
                    || index.iter().any(|(known, ids)| {
                        known
                            .strip_prefix(space)
                            .is_some_and(|rest| rest.starts_with('.'))
                            && has(ids)
                    })
            }
            Self::Model(model) => match space {
                "marker" => model.marker(id).is_some(),
                "joint" => model.joints.iter().any(|joint| joint.header.id == id),
                "variable" => model.variables.iter().any(|v| v.header.id == id),
                "spline" => model.splines.iter().any(|spline| spline.header.id == id),
                "array" => model.arrays.iter().any(|array| array.header.id == id),
                "diff" => model.diffs.iter().any(|diff| diff.header.id == id),
                // The model does not keep the others, or keeps them under several kinds.
                _ => true,
            },
        }
    }

    /// True if two statements of a dataset have the same id in one space.
    pub fn repeats(&self) -> bool {
        matches!(self, Self::Dataset { repeats: true, .. })
    }

    /// Ids of a space in order, for suggestions.
    pub fn all(&self, space: &str) -> Vec<u32> {
        let mut all: Vec<u32> = match self {
            Self::Dataset { markers, .. } if space == "marker" => markers.keys().copied().collect(),
            Self::Dataset { index, .. } => index
                .get(space)
                .map(|ids| ids.keys().copied().collect())
                .unwrap_or_default(),
            Self::Model(model) if space == "marker" => model
                .markers
                .iter()
                .map(|marker| marker.header.id)
                .collect(),
            Self::Model(_) => Vec::new(),
        };
        all.sort_unstable();
        all
    }

    /// Index of a joint in the model's list.
    pub fn joint(&self, id: u32) -> Option<usize> {
        match self {
            Self::Dataset { joints, .. } => joints.get(&id).copied(),
            Self::Model(model) => model.joints.iter().position(|joint| joint.header.id == id),
        }
    }

    /// After the joints were lowered: their ids in the order of the model's list.
    pub fn set_joints(&mut self, ids: impl Iterator<Item = u32>) {
        if let Self::Dataset { joints, .. } = self {
            *joints = ids.enumerate().map(|(at, id)| (id, at)).collect();
        }
    }

    /// A statement of the dataset whose numbers another one takes over.
    pub fn statement(&self, kind: &str, id: u32) -> Option<&'a crate::syntax::Statement> {
        match self {
            Self::Dataset { dataset, .. } => dataset.statement(kind, Some(id)),
            Self::Model(_) => None,
        }
    }
}
