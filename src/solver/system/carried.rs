//! Markers that are defined in the frames of other markers (RM) and move with them.

use crate::mechanics::{Pose, Vec3};
use crate::model::{MarkerIx, Model};
use admire_syntax::hash::QuickMap;

/// Links from markers defined relative to an RM marker to that RM marker, which may be on another part.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct Carried {
    /// For each marker with RM: its RM marker, and the pose of the RM marker's part relative to the part of the marker itself, in the
    /// design position.
    base: QuickMap<usize, (usize, Pose)>,
    /// For each marker: the markers that move with it. Each marker in the list comes after its RM marker.
    with: QuickMap<usize, Vec<usize>>,
}

/// Motion of a marker on its part per unit of a parameter: displacement and rotation vector, in part axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Moved {
    pub marker: usize,
    pub shift: Vec3,
    pub turn: Vec3,
}

impl Carried {
    pub(crate) fn of(model: &Model) -> Self {
        let mut new = Self::default();
        let part = |marker: usize| model.parts[model.markers[marker].part.0].pose;
        let mut children: QuickMap<usize, Vec<usize>> = QuickMap::default();
        for (at, marker) in model.markers.iter().enumerate() {
            if let Some(relative) = &marker.relative {
                let MarkerIx(rm) = relative.rm;
                let between = part(at).inverse().compose(&part(rm));
                new.base.insert(at, (rm, between));
                children.entry(rm).or_default().push(at);
            }
        }
        for &first in children.keys() {
            let mut with = children[&first].clone();
            let mut next = 0;
            while let Some(marker) = with.get(next) {
                // Cyclic references are rejected elsewhere; the loop also ends for them.
                let further = children.get(marker).into_iter().flatten().copied();
                let further: Vec<usize> = further
                    .filter(|marker| *marker != first && !with.contains(marker))
                    .collect();
                with.extend(further);
                next += 1;
            }
            new.with.insert(first, with);
        }
        new
    }

    /// Returns the RM marker of a marker, and the pose of the RM marker's part relative to the marker's own part.
    pub(crate) fn base(&self, marker: usize) -> Option<&(usize, Pose)> {
        self.base.get(&marker)
    }

    /// Returns whether a marker is defined in the frame of another marker (RM).
    pub(crate) fn is_carried(&self, marker: usize) -> bool {
        self.base.contains_key(&marker)
    }

    /// Returns the markers that move with a marker, without the marker itself. Each marker in the list comes after its RM marker.
    pub(crate) fn with(&self, marker: usize) -> &[usize] {
        self.with.get(&marker).map_or(&[], Vec::as_slice)
    }

    /// Returns whether `marker` moves when marker `first` moves.
    pub(crate) fn moves(&self, first: usize, marker: usize) -> bool {
        first == marker || self.with(first).contains(&marker)
    }
}
