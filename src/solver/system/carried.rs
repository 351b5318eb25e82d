//! Markers that are given in the frames of other markers (RM) and move with them.

use crate::mechanics::{Pose, Vec3};
use crate::model::{MarkerIx, Model};
use admire_syntax::hash::QuickMap;

/// Which markers are given in the frame of which, whatever their parts.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct Carried {
    /// Of a marker with RM: that one, and the frame of its part on the part of the marker, at design.
    base: QuickMap<usize, (usize, Pose)>,
    /// Of a marker: those that move with it, each behind the one in whose frame it is given.
    with: QuickMap<usize, Vec<usize>>,
}

/// How a marker moves on its part per unit of a number: displacement and rotation vector, in axes of the part.
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
                // Markers in each other's frames were refused; they end here all the same.
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

    /// The marker in whose frame one is given, and the frame of that one's part on its own.
    pub(crate) fn base(&self, marker: usize) -> Option<&(usize, Pose)> {
        self.base.get(&marker)
    }

    /// True for a marker that is given in the frame of another one.
    pub(crate) fn is_carried(&self, marker: usize) -> bool {
        self.base.contains_key(&marker)
    }

    /// The markers that move with one, without itself; each behind the one in whose frame it is given.
    pub(crate) fn with(&self, marker: usize) -> &[usize] {
        self.with.get(&marker).map_or(&[], Vec::as_slice)
    }

    /// True if a marker moves when `first` does.
    pub(crate) fn moves(&self, first: usize, marker: usize) -> bool {
        first == marker || self.with(first).contains(&marker)
    }
}
