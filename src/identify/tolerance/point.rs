//! Hardpoints: the points at which parts are connected.

use crate::settings::SHARED_HARDPOINT_MM;
use admire_solver::mechanics::Vec3;
use admire_solver::model::{MarkerIx, Model};

/// A hardpoint: a connection point of the axle, with all markers that coincide there in the design position.
#[derive(Clone, PartialEq, Debug)]
pub struct ConnectionPoint {
    /// Position in ground, at the design position of the deck.
    pub place: Vec3,
    /// Markers at the hardpoint, in the order of the deck.
    pub markers: Vec<MarkerIx>,
}

/// Returns the hardpoints of a deck: the end points of all active joints, joint primitives, bushings, FIELDs and
/// springs.
pub fn points(model: &Model) -> Vec<ConnectionPoint> {
    let joints = model
        .joints
        .iter()
        .filter(|j| j.header.active)
        .map(|j| (j.i, j.j));
    let primitives = model
        .primitives
        .iter()
        .filter(|p| p.header.active)
        .map(|p| (p.i, p.j));
    let elastic = model.elastic_pairs();
    let elastic = elastic.filter(|e| e.header.active).map(|e| (e.i, e.j));
    let springs = model
        .springdampers
        .iter()
        .filter(|s| s.header.active)
        .map(|s| (s.i, s.j));
    let mut ends: Vec<MarkerIx> = joints
        .chain(primitives)
        .chain(elastic)
        .chain(springs)
        .flat_map(|(i, j)| [i, j])
        .collect();
    ends.sort_by_key(|marker| marker.0);
    ends.dedup();
    let near = SHARED_HARDPOINT_MM * 1e-3 / model.units.length.si;
    let mut out: Vec<ConnectionPoint> = Vec::new();
    for marker in ends {
        let of = &model.markers[marker.0];
        let place = model.parts[of.part.0].pose.point(&of.qp);
        match out
            .iter_mut()
            .find(|point| (point.place - place).norm() < near)
        {
            Some(point) => point.markers.push(marker),
            None => out.push(ConnectionPoint {
                place,
                markers: vec![marker],
            }),
        }
    }
    out
}
