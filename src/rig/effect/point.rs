//! Points of the car: the design positions where joints, bushings, springs and forces connect parts.

use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::{JointKind, MarkerIx, Model, PrimitiveKind, SforceKind};

/// Markers closer together than this fraction of the deck's extent belong to one point.
const NEAR: f64 = 1e-3;

/// One point of the car with the markers that move with it.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Point {
    /// Ids of the markers of connections that meet at the point, sorted.
    pub members: Vec<u32>,
    /// Ids of the far markers of sliding joints that have their other marker at the point. They move as well, so that the parts still fit.
    pub followers: Vec<u32>,
}

impl Point {
    /// Id of the point in the deck: the smallest marker id.
    pub(crate) fn id(&self) -> u32 {
        self.members[0]
    }
}

/// A connection of two parts: its markers, and whether one part slides on the other.
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

/// Returns the ids of markers at which joints, primitives and springs hold a part, with their positions on it, sorted by id.
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

/// Returns the position of a marker in the design configuration.
fn place(model: &Model, marker: MarkerIx) -> Vec3 {
    let frame = &model.markers[marker.0];
    model.parts[frame.part.0].pose.point(&frame.qp)
}

/// Returns all points of a deck, in the order of their smallest ids.
///
/// A marker that only guides a sliding joint and meets nothing else is not a point of its own: it follows the joint's other marker.
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

/// Returns the diagonal of the bounding box of some positions.
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

/// Transforms a shift from ground axes to the axes of the part that carries a marker.
pub(super) fn on_part(model: &Model, marker: u32, shift: &Vec3) -> Option<Vec3> {
    let frame = &model.markers[model.marker(marker)?.0];
    let Pose { R, .. } = model.parts[frame.part.0].pose;
    Some(R.transpose() * shift)
}
