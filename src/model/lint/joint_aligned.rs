use super::Design;
use crate::diagnostic::{Code, Diagnostic};
use crate::mechanics::{Pose, Vec3};
use crate::model::{Header, JointKind, MarkerIx, PrimitiveKind};

/// Origins may be so far apart, as a share of the size of the model: what ten printed digits leave.
const GAP: f64 = 1e-5;
/// Axes may differ by so much, in degrees.
const TILT: f64 = 0.1;

/// What a constraint asks of its markers at the design position.
#[derive(Clone, Copy, Default)]
struct Wanted {
    /// Which components of the distance of I from J, in J axes, are zero.
    distance: [bool; 3],
    /// Axes of I along the same axes of J.
    x_along_x: bool,
    z_along_z: bool,
    /// The z axes are parallel in either direction.
    z_parallel: bool,
    /// The z axes are normal.
    z_normal: bool,
    /// x of I is normal to y of J.
    x_normal_y: bool,
}

/// Joints and primitives whose markers do not lie as the constraint needs them at the design position.
pub(super) fn check(design: &Design<'_>, found: &mut Vec<Diagnostic>) {
    let size = size(design);
    for joint in &design.model.joints {
        let wanted = of_joint(joint.kind);
        pair(
            design,
            "JOINT",
            &joint.header,
            (joint.i, joint.j),
            wanted,
            size,
            found,
        );
    }
    for primitive in &design.model.primitives {
        let wanted = of_primitive(primitive.kind);
        let markers = (primitive.i, primitive.j);
        pair(
            design,
            "JPRIM",
            &primitive.header,
            markers,
            wanted,
            size,
            found,
        );
    }
}

fn of_joint(kind: JointKind) -> Wanted {
    let point = Wanted {
        distance: [true; 3],
        ..Wanted::default()
    };
    let line = Wanted {
        distance: [true, true, false],
        z_along_z: true,
        ..Wanted::default()
    };
    match kind {
        JointKind::Spherical | JointKind::Convel => point,
        JointKind::Revolute => Wanted {
            z_along_z: true,
            ..point
        },
        JointKind::Fixed => Wanted {
            z_along_z: true,
            x_along_x: true,
            ..point
        },
        JointKind::Cylindrical => line,
        JointKind::Translational => Wanted {
            x_along_x: true,
            ..line
        },
        JointKind::Planar => Wanted {
            distance: [false, false, true],
            z_along_z: true,
            ..Wanted::default()
        },
        JointKind::Hooke => Wanted {
            x_normal_y: true,
            ..point
        },
        JointKind::Universal => Wanted {
            z_normal: true,
            ..point
        },
        // One relation of travel and turn: any position is a start.
        JointKind::Screw { .. } | JointKind::RackPin { .. } => Wanted::default(),
    }
}

fn of_primitive(kind: PrimitiveKind) -> Wanted {
    let none = Wanted::default();
    match kind {
        PrimitiveKind::AtPoint => Wanted {
            distance: [true; 3],
            ..none
        },
        PrimitiveKind::Inline => Wanted {
            distance: [true, true, false],
            ..none
        },
        PrimitiveKind::Inplane => Wanted {
            distance: [false, false, true],
            ..none
        },
        PrimitiveKind::Orientation => Wanted {
            x_along_x: true,
            z_along_z: true,
            ..none
        },
        PrimitiveKind::ParallelAxes => Wanted {
            z_parallel: true,
            ..none
        },
        PrimitiveKind::Perpendicular => Wanted {
            z_normal: true,
            ..none
        },
    }
}

/// The diagonal of the box that holds every marker.
fn size(design: &Design<'_>) -> f64 {
    let mut low = Vec3::repeat(f64::INFINITY);
    let mut high = Vec3::repeat(f64::NEG_INFINITY);
    for index in 0..design.model.markers.len() {
        if let Some(pose) = design.pose(MarkerIx(index)) {
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
    wanted: Wanted,
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
    found.push(
        design.warning(Code::JointNotAligned, header, message).help(
            "the parts are moved when the model is assembled; mend QP and REULER of a marker",
        ),
    );
}

fn faults(i: &Pose, j: &Pose, wanted: Wanted, size: f64, unit: &str) -> Vec<String> {
    let mut faults = Vec::new();
    // Distance of I from J, in J axes.
    let p_ij_j = j.R.transpose() * (i.p - j.p);
    let mut off = Vec3::zeros();
    for (axis, counts) in wanted.distance.iter().enumerate() {
        if *counts {
            off[axis] = p_ij_j[axis];
        }
    }
    if off.norm() > GAP * size {
        faults.push(format!("I is {:.4} {unit} away", off.norm()));
    }
    let R_ji = j.R.transpose() * i.R;
    let between = |a: usize, b: usize| R_ji[(b, a)].clamp(-1.0, 1.0).acos().to_degrees();
    let mut tilt = |angle: f64, from: f64, text: &str| {
        if (angle - from).abs() > TILT {
            faults.push(format!("{text} {angle:.2} degrees, not {from}"));
        }
    };
    if wanted.z_along_z {
        tilt(between(2, 2), 0.0, "the z axes make");
    }
    if wanted.x_along_x {
        tilt(between(0, 0), 0.0, "the x axes make");
    }
    if wanted.z_parallel {
        let angle = between(2, 2);
        tilt(angle.min(180.0 - angle), 0.0, "the z axes make");
    }
    if wanted.z_normal {
        tilt(between(2, 2), 90.0, "the z axes make");
    }
    if wanted.x_normal_y {
        tilt(between(0, 1), 90.0, "x of I and y of J make");
    }
    faults
}
