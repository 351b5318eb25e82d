//! Bushings and joints whose two markers lie apart, or are turned, where their element holds them together.

use crate::{LoadedStudy, Place};
use admire_solver::mechanics::{Mat3, Vec3, log};
use admire_solver::model::lint::apart;
use admire_solver::model::{MarkerIx, Model};

/// Parts that lie further apart along what holds them, in millimetres, or are turned further, in degrees, are not assembled by any tolerance.
const ASSEMBLED: (f64, f64) = (2.0, 2.0);
/// A bushing may be mounted turned by so much, in degrees, and by any angle about its own axis.
const TURNED: f64 = 10.0;

/// Two markers that lie apart.
#[derive(Clone, PartialEq, Debug)]
pub struct Displaced {
    /// What is found, and what mends it.
    pub why: String,
    /// True if one exchange, or one sign, mends it.
    pub is_mended: bool,
}

/// One way in which two markers lie apart.
#[derive(Clone, PartialEq, Debug)]
struct Gap {
    /// The name of the element.
    name: String,
    markers: (MarkerIx, MarkerIx),
    kind: Kind,
    /// Length in the deck's unit, or degrees.
    size: f64,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    Distance,
    Angle,
}

/// Bushings whose markers lie apart, and those elements that one exchange or one sign mends.
pub fn displaced(study: &LoadedStudy) -> Vec<Displaced> {
    let millimetre = 1e-3 / study.model.units.length.si;
    let mut out = Vec::new();
    for gap in gaps(study, &study.model) {
        let (most, text, told) = match gap.kind {
            Kind::Distance => {
                let unit = study.model.units.length.word;
                let text = format!("lie {:.1} {unit} apart", gap.size);
                let is_bushing = gap.name.starts_with("BUSHING/");
                (ASSEMBLED.0 * millimetre, text, is_bushing)
            }
            Kind::Angle => {
                let text = format!("are turned by {:.1} degrees", gap.size);
                (ASSEMBLED.1, text, gap.size > TURNED)
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
        let what = format!("I and J of {} {text} at design", gap.name);
        match mended {
            Some((_, change)) => out.push(Displaced {
                why: format!("{what}, and not with {change}"),
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

/// How far the markers of active bushings and joints lie apart along what is held.
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
        for (kind, size) in [(Kind::Distance, held.norm()), (Kind::Angle, turned.norm())] {
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
            kind: Kind::Distance,
            size: found.distance.norm(),
        }));
    }
    out
}

/// The model with one exchange, one sign or one mirror at either marker, and what it is called.
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
                Kind::Distance => {
                    let x = origin + to_frame * own.qp;
                    for (text, new) in one_slip(&x) {
                        let text = text.replace("{}", &name);
                        add(back * (new - origin), own.R, text);
                    }
                }
                Kind::Angle => {
                    for (of_frame, of_marker) in mirrors() {
                        let R = back * of_frame * to_frame * own.R * of_marker;
                        add(own.qp, R, format!("the axes of {name} mirrored"));
                    }
                }
            }
        }
    }
    out
}

/// A place with two coordinates exchanged, or one of the other sign; `{}` stands for its name.
fn one_slip(x: &Vec3) -> Vec<(String, Vec3)> {
    const NAMES: [&str; 3] = ["x", "y", "z"];
    let mut out = Vec::new();
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        let mut new = *x;
        new.swap_rows(a, b);
        out.push((
            format!("{} and {} of {{}} exchanged", NAMES[a], NAMES[b]),
            new,
        ));
    }
    for axis in 0..3 {
        let mut new = *x;
        new[axis] = -new[axis];
        out.push((format!("the other sign of {} of {{}}", NAMES[axis]), new));
    }
    out
}

/// Mirrors of a frame through the planes of its axes, with a mirror of the marker's own that makes it right-handed again.
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
