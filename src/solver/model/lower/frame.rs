use super::reader::Reader;
use crate::mechanics::{Mat3, Pose, Vec3, euler313};
use crate::model::{
    InitialVelocity, Marker, MarkerIx, Model, Orientation, Part, PartIx, PartKind, Relative,
};
use admire_syntax::Stated;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Lowers a PART, a POINT_MASS or a body that only real ADAMS solves.
#[allow(clippy::unnecessary_wraps)] // All lowering functions share one signature.
pub(super) fn part(reader: &mut Reader) -> Option<Part> {
    let kind = match reader.def.name {
        "POINT_MASS" => PartKind::PointMass,
        "PART" if reader.has("GROUND") => PartKind::Ground,
        "PART" => PartKind::Rigid,
        _ => PartKind::External,
    };
    let p = reader.vector("QG");
    let R = orientation(reader, "REULER", "ZG", "XG", p).0;
    let words = reader.choices("EXACT").unwrap_or_default();
    let exact = ["X", "Y", "Z", "PSI", "THETA", "PHI"].map(|word| words.contains(&word));
    let mut part = Part {
        header: reader.header(),
        kind,
        mass: reader.real("MASS"),
        cm: reader.marker("CM"),
        ip: reader.array("IP"),
        pose: Pose { p, R },
        exact,
        start: start(reader),
    };
    if kind == PartKind::Ground {
        part.pose = Pose::identity();
    }
    Some(part)
}

fn start(reader: &Reader) -> InitialVelocity {
    InitialVelocity {
        linear: ["VX", "VY", "VZ"].map(|name| reader.first(name)),
        linear_axes: reader.marker("VM"),
        angular: ["WX", "WY", "WZ"].map(|name| reader.first(name)),
        angular_axes: reader.marker("WM"),
    }
}

/// Lowers a MARKER.
///
/// A marker that names no body is on `before`, the PART, POINT_MASS or FLEX_BODY defined before the marker (`state_marker`). A marker that
/// moves along a curve or on a surface has no body, and the model is then not solved. The frame of a marker with RM is completed by
/// [`place_relative`] when all markers are known.
#[allow(clippy::unnecessary_wraps)] // All lowering functions share one signature.
pub(super) fn marker(reader: &mut Reader, before: Option<PartIx>) -> Option<Marker> {
    let part = match (named_body(reader), before) {
        (Some(part), _) => part,
        (None, _) if moves(reader) => PartIx(0),
        (None, Some(before)) => before,
        (None, None) => {
            reader.missing::<()>("a body: PART=id, or a position in the file after its PART");
            PartIx(0)
        }
    };
    let qp = reader.vector("QP");
    let (R, given) = orientation(reader, "REULER", "ZP", "XP", qp);
    let orientation = given.unwrap_or(Orientation::Reuler([0.0; 3]));
    Some(Marker {
        header: reader.header(),
        part,
        qp,
        orientation,
        R,
        floating: reader.has("FLOATING"),
        relative: reader.marker("RM").map(|rm| Relative {
            rm,
            qp,
            orientation,
            R,
        }),
    })
}

/// Returns whether a marker moves along a CURVE or on a SURFACE.
pub(super) fn moves(marker: &Stated) -> bool {
    marker.has("CURVE") || marker.has("SURFACE")
}

/// Returns the body that a marker names. If that body is undefined, which was already reported, returns the first part, so that every
/// marker keeps its index.
fn named_body(reader: &Reader) -> Option<PartIx> {
    let (name, space) = [
        ("PART", "part"),
        ("POINT_MASS", "point_mass"),
        ("FLEX_BODY", "flex_body"),
        ("FE_PART", "fe_part"),
    ]
    .into_iter()
    .find(|(name, _)| reader.has(name))?;
    Some(reader.part(name, space).unwrap_or(PartIx(0)))
}

/// Returns the rotation given by Euler angles, or by points on the z axis and in the x-z plane (guide/formats.md 2.1, 2.2). The second
/// value is the form in which the rotation was given.
fn orientation(
    reader: &mut Reader,
    euler: &str,
    z: &str,
    x: &str,
    origin: Vec3,
) -> (Mat3, Option<Orientation>) {
    if reader.has(euler) {
        let angles @ [psi, theta, phi] = reader.array(euler);
        return (euler313(psi, theta, phi), Some(Orientation::Reuler(angles)));
    }
    let (z_point, x_point) = (reader.point(z), reader.point(x));
    if z_point.is_none() && x_point.is_none() {
        return (Mat3::identity(), None);
    }
    let z_axis = z_point.map(|point| point - origin);
    let x_axis = x_point.map(|point| point - origin);
    let usexp = reader.has("USEXP");
    let R = axes(z_axis, x_axis, usexp);
    if R.is_none() {
        let (source, span) = reader.place(if z_point.is_some() { z } else { x });
        let diagnostic = Diagnostic::error(
            Code::OutOfRange,
            format!(
                "{z} and {x} do not define the orientation of {}",
                reader.called()
            ),
        )
        .help("both points must differ from the origin, and must not be collinear with it");
        reader.complain(diagnostic, source, span);
    }
    (R.unwrap_or_else(Mat3::identity), Some(Orientation::Points))
}

/// Returns the axes given by directions of z and x. One direction is exact; the other determines a half plane. A missing direction is
/// replaced by an axis of the base frame. Returns `None` if the directions are parallel or zero.
fn axes(z: Option<Vec3>, x: Option<Vec3>, usexp: bool) -> Option<Mat3> {
    let exact_x = (usexp && x.is_some()) || z.is_none();
    let unit = |v: Vec3| v.try_normalize(1e-12);
    if exact_x {
        let x = unit(x?)?;
        let z = z.unwrap_or_else(Vec3::z);
        // If x lies along the base's z axis, the base's negative x axis determines z.
        let z = unit(z - x * x.dot(&z)).or_else(|| unit(-Vec3::x() + x * x.x))?;
        return Some(Mat3::from_columns(&[x, z.cross(&x), z]));
    }
    let z = unit(z?)?;
    let given = x.is_some();
    let x = x.unwrap_or_else(Vec3::x);
    let across = unit(x - z * z.dot(&x));
    let x = match across {
        Some(x) => x,
        None if given => return None,
        // If z lies along the base's x axis, the base's y axis determines x.
        None => unit(Vec3::y() - z * z.y)?,
    };
    Some(Mat3::from_columns(&[x, z.cross(&x), z]))
}

/// Computes the part frames of the markers that are given relative to another marker (RM). Each marker is placed after its reference
/// marker. Returns the markers whose references form a cycle.
pub(super) fn place_relative(model: &mut Model) -> Vec<MarkerIx> {
    let parent = |model: &Model, marker: MarkerIx| {
        let relative = model.markers[marker.0].relative.as_ref();
        relative.map(|relative| relative.rm)
    };
    let mut done = std::collections::HashSet::new();
    let mut cyclic = Vec::new();
    for start in (0..model.markers.len()).map(MarkerIx) {
        // Chain of markers, each given relative to the next.
        let mut chain = Vec::new();
        let mut waiting = std::collections::HashSet::new();
        let mut marker = start;
        while let Some(rm) = parent(model, marker)
            && !done.contains(&marker)
        {
            if !waiting.insert(marker) {
                cyclic.push(start);
                break;
            }
            chain.push(marker);
            marker = rm;
        }
        while let Some(marker) = chain.pop() {
            done.insert(marker);
            place_in(model, marker);
        }
    }
    cyclic
}

/// Computes the frame of a marker on its own part from the frame given relative to RM.
fn place_in(model: &mut Model, marker: MarkerIx) {
    let own = &model.markers[marker.0];
    let Some(relative) = &own.relative else {
        return;
    };
    let rm = &model.markers[relative.rm.0];
    let body = |part: PartIx| model.parts[part.0].pose;
    let rm_pose = body(rm.part).compose(&Pose { p: rm.qp, R: rm.R });
    let stated = Pose {
        p: relative.qp,
        R: relative.R,
    };
    let placed = body(own.part).inverse().compose(&rm_pose).compose(&stated);
    let own = &mut model.markers[marker.0];
    own.qp = placed.p;
    own.R = placed.R;
    own.orientation = Orientation::Points;
}

/// Converts inertia given about the marker IM to the origin and axes of the marker CM, as stored in the model.
pub(super) fn inertia_about(model: &mut Model, part: PartIx, im: MarkerIx) {
    let part = &mut model.parts[part.0];
    let Some(cm) = part.cm.filter(|cm| *cm != im) else {
        return;
    };
    let (cm, im) = (&model.markers[cm.0], &model.markers[im.0]);
    let [xx, yy, zz, xy, xz, yz] = part.ip;
    // IP holds the products of inertia as positive integrals, so the off-diagonal entries of the matrix are their negatives
    // (guide/formats.md 2.1).
    let J_im = Mat3::new(xx, -xy, -xz, -xy, yy, -yz, -xz, -yz, zz);
    let d = cm.qp - im.qp;
    let steiner = Mat3::identity() * d.norm_squared() - d * d.transpose();
    let J = im.R * J_im * im.R.transpose() - steiner * part.mass;
    let J_cm = cm.R.transpose() * J * cm.R;
    part.ip = [
        J_cm[(0, 0)],
        J_cm[(1, 1)],
        J_cm[(2, 2)],
        -J_cm[(0, 1)],
        -J_cm[(0, 2)],
        -J_cm[(1, 2)],
    ];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_give_axes_and_usexp_swaps_their_roles() {
        // guide/formats.md 2.2: ZP lies on z, XP in the x-z plane; with USEXP XP lies on x.
        let z = Vec3::new(0.0, 0.0, 2.0);
        let x = Vec3::new(1.0, 0.0, 1.0);
        let R = axes(Some(z), Some(x), false).unwrap();
        assert!((R - Mat3::identity()).norm() < 1e-15);
        let R = axes(Some(z), Some(x), true).unwrap();
        assert!((R.column(0) - x.normalize()).norm() < 1e-15);
        assert!((R.column(2) - Vec3::new(-1.0, 0.0, 1.0).normalize()).norm() < 1e-15);
        assert!((R.determinant() - 1.0).abs() < 1e-15);
        assert!(axes(Some(z), Some(z * 3.0), false).is_none());
        assert!(axes(Some(Vec3::zeros()), None, false).is_none());
    }
}
