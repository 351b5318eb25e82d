//! Connection points (hardpoints): the design positions at which joints, bushings, springs and forces connect parts.

use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::{JointKind, MarkerIx, Model, PrimitiveKind, SforceKind};

/// Distance up to which two markers belong to the same connection point, as a fraction of the extent of the deck.
const NEAR: f64 = 1e-3;

/// A connection point (hardpoint), with the markers that move with it.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Point {
    /// Ids of the markers of all connections that meet at the point, in ascending order.
    pub members: Vec<u32>,
    /// Ids of markers of sliding joints whose other marker is at the point. They move with the point, so that the parts still fit together.
    pub followers: Vec<u32>,
}

impl Point {
    /// Returns the id of the point, which is the smallest id of its markers.
    pub(crate) fn id(&self) -> u32 {
        self.members[0]
    }
}

/// A connection between two parts: its two markers, and whether one part slides on the other.
struct Connection {
    markers: [MarkerIx; 2],
    slides: bool,
}

fn connections(model: &Model) -> Vec<Connection> {
    let joints = model.joints.iter().map(|joint| {
        let slides = [
            JointKind::Translational,
            JointKind::Cylindrical,
            JointKind::Planar,
        ];
        let screw = matches!(joint.kind, JointKind::Screw { .. });
        (joint.i, joint.j, screw || slides.contains(&joint.kind))
    });
    let holds = |kind| {
        matches!(
            kind,
            PrimitiveKind::AtPoint | PrimitiveKind::Inline | PrimitiveKind::Inplane
        )
    };
    let primitives = model.primitives.iter().filter(|o| holds(o.kind));
    let primitives = primitives.map(|o| (o.i, o.j, o.kind != PrimitiveKind::AtPoint));
    let bushings = model.bushings.iter().map(|o| (o.i, o.j, false));
    let springs = model.springdampers.iter().map(|o| (o.i, o.j, false));
    let pairs = model.pair_forces.iter().map(|o| (o.i, o.j, false));
    let forces = model.sforces.iter();
    let forces = forces.filter(|o| !o.action_only && o.kind == SforceKind::Translational);
    let forces = forces.map(|o| (o.i, o.j, false));
    let all = joints.chain(primitives).chain(bushings).chain(springs);
    let all = all.chain(pairs).chain(forces);
    all.map(|(i, j, slides)| Connection {
        markers: [i, j],
        slides,
    })
    .collect()
}

/// Returns the markers at which joints, joint primitives and springs hold a part. Each entry consists of the id of the marker and its position
/// on the part. The list is sorted by id.
pub(crate) fn held(model: &Model) -> Vec<(u32, Vec3)> {
    let joints = model.joints.iter().map(|o| [o.i, o.j]);
    let primitives = model.primitives.iter().map(|o| [o.i, o.j]);
    let springs = model.springdampers.iter().map(|o| [o.i, o.j]);
    let all = joints.chain(primitives).chain(springs).flatten();
    let mut found: Vec<_> = all
        .map(|marker| {
            let marker = &model.markers[marker.0];
            (marker.header.id, marker.qp)
        })
        .collect();
    found.sort_by_key(|(id, _)| *id);
    found.dedup_by_key(|(id, _)| *id);
    found
}

/// Returns the position of a marker in ground, in the design position.
fn place(model: &Model, marker: MarkerIx) -> Vec3 {
    let frame = &model.markers[marker.0];
    model.parts[frame.part.0].pose.point(&frame.qp)
}

/// Returns all connection points of a deck, in the order of their ids.
///
/// A marker that belongs only to a sliding joint is not a separate point. It follows the other marker of the joint.
pub(crate) fn points(model: &Model) -> Vec<Point> {
    let connections = connections(model);
    let mut markers: Vec<MarkerIx> = connections.iter().flat_map(|c| c.markers).collect();
    markers.sort_by_key(|marker| model.markers[marker.0].header.id);
    markers.dedup();
    let places: Vec<Vec3> = markers.iter().map(|m| place(model, *m)).collect();
    let near = NEAR * extent(&places);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (at, here) in places.iter().enumerate() {
        let meets = |group: &Vec<usize>| group.iter().any(|k| (places[*k] - here).norm() <= near);
        match groups.iter_mut().find(|group| meets(group)) {
            Some(group) => group.push(at),
            None => groups.push(vec![at]),
        }
    }
    let group_of = |marker: MarkerIx| {
        let at = markers.iter().position(|other| *other == marker)?;
        groups.iter().position(|group| group.contains(&at))
    };
    let mut guides = vec![false; groups.len()];
    let mut followers: Vec<Vec<u32>> = vec![Vec::new(); groups.len()];
    for connection in connections.iter().filter(|connection| connection.slides) {
        let [Some(a), Some(b)] = connection.markers.map(group_of) else {
            continue;
        };
        if a == b {
            continue;
        }
        let ids = connection.markers.map(|m| model.markers[m.0].header.id);
        followers[a].push(ids[1]);
        followers[b].push(ids[0]);
        let guide = if groups[a].len() <= groups[b].len() {
            a
        } else {
            b
        };
        guides[guide] |= groups[guide].len() == 1;
    }
    let kept = groups.iter().zip(followers).zip(guides);
    kept.filter(|(_, guide)| !guide)
        .map(|((group, followers), _)| Point {
            members: group
                .iter()
                .map(|k| model.markers[markers[*k].0].header.id)
                .collect(),
            followers,
        })
        .collect()
}

/// Returns the length of the diagonal of the bounding box of these positions.
fn extent(places: &[Vec3]) -> f64 {
    let Some(first) = places.first() else {
        return 0.0;
    };
    let (mut low, mut high) = (*first, *first);
    for place in places {
        low = low.inf(place);
        high = high.sup(place);
    }
    (high - low).norm()
}

/// Transforms a shift from ground axes to the axes of the part that carries the marker with this id; `None` if there is no such marker.
pub(super) fn on_part(model: &Model, marker: u32, shift: &Vec3) -> Option<Vec3> {
    let frame = &model.markers[model.marker(marker)?.0];
    let Pose { R, .. } = model.parts[frame.part.0].pose;
    Some(R.transpose() * shift)
}
