//! Centres of the parts, which are their reference points in statics, and the length scales of a model.

use super::super::Parameters;
use super::super::structure::{Body, ConstraintEquation, Element, NForce};
use crate::mechanics::{Pose, Vec3};

/// Sets the centre of every part: its centre of mass or, without a CM marker, the mean of the markers at which joints and forces act. The
/// centre does not depend on the position of the part's frame.
pub(super) fn centres(
    bodies: &mut [Body],
    elements: &[Element],
    joints: &[ConstraintEquation],
    multis: &[NForce],
    owners: &[usize],
    parameters: &Parameters,
) {
    let ends = elements
        .iter()
        .flat_map(|e| [Some(e.i), Some(e.j), e.frame]);
    let terms = joints.iter().flat_map(|joint| &joint.terms);
    let terms = terms.flat_map(|term| [term.i, term.j]);
    let multis = multis.iter();
    let multis = multis.flat_map(|multi| multi.i.iter().copied().chain([multi.j]));
    let mut acting: Vec<usize> = ends.flatten().chain(terms).chain(multis).collect();
    acting.sort_unstable();
    acting.dedup();
    let mut sums = vec![(Vec3::zeros(), 0.0); bodies.len()];
    for marker in acting {
        let (sum, count) = &mut sums[owners[marker]];
        *sum += parameters.markers()[marker].p;
        *count += 1.0;
    }
    for (body, (sum, count)) in bodies.iter_mut().zip(sums) {
        let mean = sum / f64::max(count, 1.0);
        let centre = body.cm.map_or(mean, |cm| parameters.markers()[cm].p);
        if body.freedoms == 6 {
            body.centre = centre;
        }
    }
}

/// Distance of a marker from the centre of its part, relative to the model's extent, below which the distance counts as zero.
const NEAREST: f64 = 1e-9;

/// Returns the length scale of rotations and the size of the mechanism.
///
/// The length scale is the mean distance of the used markers from the centres of their parts. The size is the distance between two remote
/// markers: the marker furthest from the first marker, and the marker furthest from that marker.
pub(super) fn sizes(
    used: &[usize],
    owners: &[usize],
    parameters: &Parameters,
    poses: &[Pose],
    bodies: &[Body],
) -> (f64, f64) {
    let place = |marker: usize| poses[owners[marker]].point(&parameters.markers()[marker].p);
    let furthest = |from: Vec3| {
        let apart = |marker: &usize| ((place(*marker) - from).norm(), *marker);
        let all = used.iter().map(apart);
        all.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0))
    };
    let first = used
        .first()
        .map_or_else(Vec3::zeros, |&marker| place(marker));
    let (extent, end) = furthest(first);
    let size = if used.is_empty() {
        0.0
    } else {
        furthest(place(end)).0
    };
    let mut sum = 0.0;
    let mut count = 0;
    for &marker in used {
        let arm = (parameters.markers()[marker].p - bodies[owners[marker]].centre).norm();
        // Arms that are negligible relative to the model give no length scale.
        if arm > NEAREST * extent && owners[marker] != 0 {
            sum += arm;
            count += 1;
        }
    }
    let length = if count == 0 {
        1.0
    } else {
        sum / f64::from(count)
    };
    (length, size)
}
