use super::Design;
use crate::mechanics::{Pose, Vec3};
use crate::model::{Header, JointKind, MarkerIx, Model, PrimitiveKind};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Allowed distance between marker origins, relative to the size of the model. It covers the rounding of coordinates printed with ten
/// digits.
const GAP: f64 = 1e-5;
/// Allowed angle between axes, in degrees. ADAMS does not report joints tilted by nearly this angle (grammar/NOTES.md).
const TILT: f64 = 1.0;

/// Alignment that a constraint requires of its markers at the design position.
#[derive(Clone, Copy, Default)]
struct Alignment {
    /// Components of the vector from J to I, in J axes, that must be zero.
    distance: [bool; 3],
    /// Whether the x axes must be parallel and point the same way.
    x_along_x: bool,
    /// Whether the z axes must be parallel and point the same way.
    z_along_z: bool,
    /// Whether the z axes must be parallel, in either direction.
    z_parallel: bool,
    /// Whether the z axes must be perpendicular.
    z_normal: bool,
    /// Whether the x axis of I must be perpendicular to the y axis of J.
    x_normal_y: bool,
}

/// Reports joints and primitives whose markers are not aligned at the design position as the constraint requires.
pub(super) fn check(design: &Design<'_>, found: &mut Vec<Diagnostic>) {
    let size = size(design.model);
    for (kind, header, markers, wanted) in pairs(design.model) {
        pair(design, kind, header, markers, wanted, size, found);
    }
}

/// Constraint whose marker origins do not coincide as the constraint requires.
pub struct MarkerGap {
    /// Name of the constraint.
    pub name: String,
    /// Vector from J to I in the axes of J; zero along unconstrained axes.
    pub distance: Vec3,
    /// Whether the constraint acts along each axis of J.
    pub counts: [bool; 3],
}

/// Returns the active constraints whose marker origins lie apart along a constrained axis in the design position, in the order of the
/// model.
pub fn apart(model: &Model) -> Vec<MarkerGap> {
    let size = size(model);
    let mut found = Vec::new();
    for (_, header, (i, j), wanted) in pairs(model).filter(|(_, header, ..)| header.active) {
        let (Some(i), Some(j)) = (model.marker_pose(i), model.marker_pose(j)) else {
            continue;
        };
        let distance = distance(&i, &j, wanted);
        if distance.norm() > GAP * size {
            found.push(MarkerGap {
                name: header.name.clone(),
                distance,
                counts: wanted.distance,
            });
        }
    }
    found
}

/// Returns every joint and joint primitive with the alignment that it requires.
fn pairs(
    model: &Model,
) -> impl Iterator<Item = (&'static str, &Header, (MarkerIx, MarkerIx), Alignment)> {
    let joints = model.joints.iter().map(|joint| {
        let markers = (joint.i, joint.j);
        ("JOINT", &joint.header, markers, of_joint(joint.kind))
    });
    let primitives = model.primitives.iter().map(|primitive| {
        let markers = (primitive.i, primitive.j);
        let wanted = of_primitive(primitive.kind);
        ("JPRIM", &primitive.header, markers, wanted)
    });
    joints.chain(primitives)
}

fn of_joint(kind: JointKind) -> Alignment {
    let point = Alignment {
        distance: [true; 3],
        ..Alignment::default()
    };
    let line = Alignment {
        distance: [true, true, false],
        z_along_z: true,
        ..Alignment::default()
    };
    match kind {
        JointKind::Spherical | JointKind::Convel => point,
        JointKind::Revolute => Alignment {
            z_along_z: true,
            ..point
        },
        JointKind::Fixed => Alignment {
            z_along_z: true,
            x_along_x: true,
            ..point
        },
        JointKind::Cylindrical => line,
        JointKind::Translational => Alignment {
            x_along_x: true,
            ..line
        },
        JointKind::Planar => Alignment {
            distance: [false, false, true],
            z_along_z: true,
            ..Alignment::default()
        },
        JointKind::Hooke => Alignment {
            x_normal_y: true,
            ..point
        },
        JointKind::Universal => Alignment {
            z_normal: true,
            ..point
        },
        // These joints only couple translation and rotation, so every initial position is allowed.
        JointKind::Screw { .. } | JointKind::RackPin { .. } => Alignment::default(),
    }
}

fn of_primitive(kind: PrimitiveKind) -> Alignment {
    let none = Alignment::default();
    match kind {
        PrimitiveKind::AtPoint => Alignment {
            distance: [true; 3],
            ..none
        },
        PrimitiveKind::Inline => Alignment {
            distance: [true, true, false],
            ..none
        },
        PrimitiveKind::Inplane => Alignment {
            distance: [false, false, true],
            ..none
        },
        PrimitiveKind::Orientation => Alignment {
            x_along_x: true,
            z_along_z: true,
            ..none
        },
        PrimitiveKind::ParallelAxes => Alignment {
            z_parallel: true,
            ..none
        },
        PrimitiveKind::Perpendicular => Alignment {
            z_normal: true,
            ..none
        },
    }
}

/// Returns the diagonal of the bounding box of all markers.
fn size(model: &Model) -> f64 {
    let mut low = Vec3::repeat(f64::INFINITY);
    let mut high = Vec3::repeat(f64::NEG_INFINITY);
    for index in 0..model.markers.len() {
        if let Some(pose) = model.marker_pose(MarkerIx(index)) {
            low = low.inf(&pose.p);
            high = high.sup(&pose.p);
        }
    }
    let diagonal = (high - low).norm();
    if diagonal.is_finite() { diagonal } else { 0.0 }
}

fn pair(
    design: &Design<'_>,
    kind: &str,
    header: &Header,
    (i, j): (MarkerIx, MarkerIx),
    wanted: Alignment,
    size: f64,
    found: &mut Vec<Diagnostic>,
) {
    let Some((i, j)) = design.pair(i, j) else {
        return;
    };
    let faults = faults(&i, &j, wanted, size, design.model.units.length.word);
    if faults.is_empty() {
        return;
    }
    let message = format!(
        "the markers of {} are not aligned at the design position: {}",
        design.title(kind, header),
        faults.join("; ")
    );
    found.push(design.warning(Code::JointNotAligned, header, message).help(
        "ADAMS moves the parts when it assembles the model; correct QP and REULER of one marker",
    ));
}

/// Returns the vector from J to I in J axes; zero along unconstrained axes.
fn distance(i: &Pose, j: &Pose, wanted: Alignment) -> Vec3 {
    let p_ij_j = j.R.transpose() * (i.p - j.p);
    Vec3::from_fn(|axis, _| {
        if wanted.distance[axis] {
            p_ij_j[axis]
        } else {
            0.0
        }
    })
}

fn faults(i: &Pose, j: &Pose, wanted: Alignment, size: f64, unit: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let off = distance(i, j, wanted);
    if off.norm() > GAP * size {
        faults.push(format!("I is {:.4} {unit} away from J", off.norm()));
    }
    let R_ji = j.R.transpose() * i.R;
    let between = |a: usize, b: usize| libm::acos(R_ji[(b, a)].clamp(-1.0, 1.0)).to_degrees();
    let mut tilt = |angle: f64, from: f64, text: &str| {
        if (angle - from).abs() > TILT {
            faults.push(format!("{text} {angle:.2} degrees, not {from}"));
        }
    };
    if wanted.z_along_z {
        tilt(between(2, 2), 0.0, "the angle between the z axes is");
    }
    if wanted.x_along_x {
        tilt(between(0, 0), 0.0, "the angle between the x axes is");
    }
    if wanted.z_parallel {
        let angle = between(2, 2);
        tilt(
            angle.min(180.0 - angle),
            0.0,
            "the angle between the z axes is",
        );
    }
    if wanted.z_normal {
        tilt(between(2, 2), 90.0, "the angle between the z axes is");
    }
    if wanted.x_normal_y {
        tilt(
            between(0, 1),
            90.0,
            "the angle between x of I and y of J is",
        );
    }
    faults
}
