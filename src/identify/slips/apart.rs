//! Detection of bushings and joints whose two markers are displaced or rotated relative to each other along directions that the element
//! constrains.

use crate::settings::{ASSEMBLY_ANGLE_DEG, ASSEMBLY_DISTANCE_MM, REPORTED_BUSHING_ANGLE_DEG};
use crate::{LoadedStudy, Place};
use admire_solver::mechanics::{Mat3, Vec3, log};
use admire_solver::model::lint::apart;
use admire_solver::model::{MarkerIx, Model};

/// A bushing or joint whose two markers do not coincide in the design position.
#[derive(Clone, PartialEq, Debug)]
pub struct Displaced {
    /// Description of the displacement, and of its correction if there is one.
    pub why: String,
    /// True if exchanging two coordinates or changing one sign corrects the displacement.
    pub is_mended: bool,
}

/// Distance or rotation between the two markers of a bushing or joint.
#[derive(Clone, PartialEq, Debug)]
struct Gap {
    /// Name of the bushing or joint.
    name: String,
    markers: (MarkerIx, MarkerIx),
    kind: ApartKind,
    /// Distance in the deck's length unit, or rotation angle in degrees.
    size: f64,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum ApartKind {
    Distance,
    Angle,
}

/// Returns the bushings whose markers are displaced or strongly rotated. Also returns the bushings with a smaller rotation and the joints with a
/// displacement, if one change of a marker corrects it: an exchange of two coordinates, a change of one sign, or mirrored axes.
pub fn displaced(study: &LoadedStudy) -> Vec<Displaced> {
    let millimetre = 1e-3 / study.model.units.length.si;
    let mut out = Vec::new();
    for gap in gaps(study, &study.model) {
        let (most, text, told) = match gap.kind {
            ApartKind::Distance => {
                let unit = study.model.units.length.word;
                let text = format!("markers of {} lie {:.1} {unit} apart", gap.name, gap.size);
                let is_bushing = gap.name.starts_with("BUSHING/");
                (ASSEMBLY_DISTANCE_MM * millimetre, text, is_bushing)
            }
            ApartKind::Angle => {
                let text = format!("axes of {} differ by {:.1} degrees", gap.name, gap.size);
                (
                    ASSEMBLY_ANGLE_DEG,
                    text,
                    gap.size > REPORTED_BUSHING_ANGLE_DEG,
                )
            }
        };
        if gap.size <= most {
            continue;
        }
        let mended = changes(&study.model, &gap).into_iter().find(|(model, _)| {
            let left = gaps(study, model);
            let same = |other: &&Gap| (other.name == gap.name) && (other.kind == gap.kind);
            left.iter()
                .find(same)
                .is_none_or(|gap| gap.size <= 0.5 * most)
        });
        let what = format!("the I and J {text} at design");
        match mended {
            Some((_, change)) => out.push(Displaced {
                why: format!("{what}, but not if {change}"),
                is_mended: true,
            }),
            None if told => out.push(Displaced {
                why: what,
                is_mended: false,
            }),
            None => {}
        }
    }
    out
}

/// Returns the distances and rotations between the two markers of all active bushings and joints. Only the constrained directions count.
fn gaps(study: &LoadedStudy, model: &Model) -> Vec<Gap> {
    let mut out = Vec::new();
    for (at, bushing) in model.bushings.iter().enumerate() {
        let poses = (model.marker_pose(bushing.i), model.marker_pose(bushing.j));
        let (Some(i), Some(j), true) = (poses.0, poses.1, bushing.header.active) else {
            continue;
        };
        let is_sought = |axis: usize| {
            let own = Place::Bushing { bushing: at, axis };
            study.unknowns.iter().any(|unknown| unknown.place == own)
        };
        let stiffness = [bushing.k, bushing.kt].concat();
        let holds = |axis: usize| stiffness[axis] > 0.0 || is_sought(axis);
        let off = j.R.transpose() * (i.p - j.p);
        let held = Vec3::from_fn(|axis, _| if holds(axis) { off[axis] } else { 0.0 });
        let turn = log(&(j.R.transpose() * i.R)).map(f64::to_degrees);
        let turned = Vec3::from_fn(|axis, _| if holds(axis + 3) { turn[axis] } else { 0.0 });
        for (kind, size) in [
            (ApartKind::Distance, held.norm()),
            (ApartKind::Angle, turned.norm()),
        ] {
            out.push(Gap {
                name: format!("BUSHING/{}", bushing.header.id),
                markers: (bushing.i, bushing.j),
                kind,
                size,
            });
        }
    }
    for found in apart(model) {
        let joint = model.joints.iter().find(|j| j.header.name == found.name);
        out.extend(joint.map(|joint| Gap {
            name: format!("JOINT/{}", joint.header.id),
            markers: (joint.i, joint.j),
            kind: ApartKind::Distance,
            size: found.distance.norm(),
        }));
    }
    out
}

/// Returns modified models, each with a description. In each model, one of the two markers has two coordinates exchanged, one sign changed, or
/// its axes mirrored.
fn changes(model: &Model, gap: &Gap) -> Vec<(Model, String)> {
    let mut out = Vec::new();
    for marker in [gap.markers.1, gap.markers.0] {
        let own = &model.markers[marker.0];
        let name = format!("MARKER/{}", own.header.id);
        let pose = model.parts[own.part.0].pose;
        for (frame, to_frame, origin) in [
            ("", Mat3::identity(), Vec3::zeros()),
            (" in ground axes", pose.R, pose.p),
        ] {
            let mut add = |qp: Vec3, R: Mat3, text: String| {
                let mut new = model.clone();
                (new.markers[marker.0].qp, new.markers[marker.0].R) = (qp, R);
                out.push((new, format!("{text}{frame}")));
            };
            let back = to_frame.transpose();
            match gap.kind {
                ApartKind::Distance => {
                    let x = origin + to_frame * own.qp;
                    for (text, new) in one_slip(&x) {
                        let text = text.replace("{}", &name);
                        add(back * (new - origin), own.R, text);
                    }
                }
                ApartKind::Angle => {
                    for (of_frame, of_marker) in mirrors() {
                        let R = back * of_frame * to_frame * own.R * of_marker;
                        add(own.qp, R, format!("the axes of {name} are mirrored"));
                    }
                }
            }
        }
    }
    out
}

/// Returns the positions that differ from `x` by one slip: two coordinates exchanged, or the sign of one coordinate changed. Each has a
/// description, in which `{}` is a placeholder for the marker's name.
fn one_slip(x: &Vec3) -> Vec<(String, Vec3)> {
    const NAMES: [&str; 3] = ["x", "y", "z"];
    let mut out = Vec::new();
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        let mut new = *x;
        new.swap_rows(a, b);
        out.push((
            format!("{} and {} of {{}} are exchanged", NAMES[a], NAMES[b]),
            new,
        ));
    }
    for axis in 0..3 {
        let mut new = *x;
        new[axis] = -new[axis];
        out.push((
            format!("{} of {{}} has the opposite sign", NAMES[axis]),
            new,
        ));
    }
    out
}

/// Returns the reflections of a frame in its coordinate planes. Each is paired with a reflection of the marker's own axes, so the result is
/// again a right-handed frame.
fn mirrors() -> Vec<(Mat3, Mat3)> {
    let flipped = |axis: usize| {
        let mut flip = Mat3::identity();
        flip[(axis, axis)] = -1.0;
        flip
    };
    let each = (0..3).map(flipped);
    let own: Vec<Mat3> = each.clone().chain([-Mat3::identity()]).collect();
    each.flat_map(|of_frame| {
        own.iter()
            .map(move |own| (of_frame, *own))
            .collect::<Vec<_>>()
    })
    .collect()
}
