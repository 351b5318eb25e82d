use std::collections::HashMap;

use crate::model::{MarkerIx, Model, PartKind};
use crate::syntax::Dataset;

/// Where the objects that others refer to are.
pub(super) enum Ids<'a> {
    /// While a dataset is lowered: constant-time look-up.
    Dataset {
        /// The dataset, for what the model does not keep (MATRIX).
        dataset: &'a Dataset,
        /// Index into the model's list by id, for each id space.
        index: HashMap<&'static str, HashMap<u32, usize>>,
        /// Places of the joints in the model's list, once they are lowered.
        joints: HashMap<u32, usize>,
    },
    /// While a command redefines an object of a finished model.
    Model(&'a Model),
}

/// The id spaces of bodies: they share one list of the model.
pub(super) const BODIES: [&str; 4] = ["part", "point_mass", "flex_body", "fe_part"];

impl<'a> Ids<'a> {
    /// The ids of a dataset: bodies and markers get the index they will have, everything else the index of its statement.
    pub fn of(dataset: &'a Dataset) -> Self {
        let mut index: HashMap<&'static str, HashMap<u32, usize>> = HashMap::new();
        let mut bodies = 0;
        let mut markers = 0;
        for (at, statement) in dataset.statements().iter().enumerate() {
            let (Some(def), Some(id)) = (statement.def, statement.number()) else {
                continue;
            };
            let Some(space) = def.id else {
                continue;
            };
            let known = index.entry(space).or_default();
            if known.contains_key(&id) {
                continue;
            }
            let next = if BODIES.contains(&space) {
                bodies += 1;
                bodies - 1
            } else if space == "marker" {
                markers += 1;
                markers - 1
            } else {
                at
            };
            known.insert(id, next);
        }
        Self::Dataset {
            dataset,
            index,
            joints: HashMap::new(),
        }
    }

    /// Index of a body or a marker in the model's list; of the statement for the rest of a dataset.
    pub fn index(&self, space: &'static str, id: u32) -> Option<usize> {
        match self {
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
            Self::Dataset { index, .. } => index.iter().any(|(known, ids)| {
                (*known == space
                    || known
                        .strip_prefix(space)
                        .is_some_and(|r| r.starts_with('.')))
                    && ids.contains_key(&id)
            }),
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

    /// Ids of a space in order, for suggestions.
    pub fn all(&self, space: &str) -> Vec<u32> {
        let mut all: Vec<u32> = match self {
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
