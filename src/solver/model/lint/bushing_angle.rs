use super::Design;
use crate::mechanics::{Vec3, projected_angles};
use crate::model::{Header, MarkerIx};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Angle in degrees beyond which the projected angles are no longer the components of a rotation vector.
const LARGEST: f64 = 10.0;

/// Reports bushings, beams and fields whose I marker is rotated too far about x or y of J in the design position.
///
/// The rotation is measured from the load-free orientation: the axes of J or, for a FIELD, the angles in its LENGTH. A large rotation about
/// z alone is harmless (guide/formats.md 2.7).
pub(super) fn check(design: &Design<'_>, found: &mut Vec<Diagnostic>) {
    let model = design.model;
    for bushing in &model.bushings {
        if bushing.kt != [0.0; 3] {
            pair(
                design,
                "BUSHING",
                &bushing.header,
                (bushing.i, bushing.j),
                Vec3::zeros(),
                found,
            );
        }
    }
    for force in &model.pair_forces {
        let relaxed = match (force.def.name, force.argument("LENGTH")) {
            ("FIELD", Some(length)) => Vec3::from_column_slice(&length[3..]),
            _ => Vec3::zeros(),
        };
        let markers = (force.i, force.j);
        pair(
            design,
            force.def.name,
            &force.header,
            markers,
            relaxed,
            found,
        );
    }
}

fn pair(
    design: &Design<'_>,
    kind: &str,
    header: &Header,
    (i, j): (MarkerIx, MarkerIx),
    relaxed: Vec3,
    found: &mut Vec<Diagnostic>,
) {
    let Some((i, j)) = design.pair(i, j) else {
        return;
    };
    let angles = (projected_angles(&(j.R.transpose() * i.R)) - relaxed).map(f64::to_degrees);
    let largest = angles.x.abs().max(angles.y.abs());
    if largest <= LARGEST {
        return;
    }
    let (from, help) = if relaxed == Vec3::zeros() {
        ("", "give marker I the orientation of J")
    } else {
        (
            " from the angles of LENGTH",
            "set the angles of LENGTH to those of I in J",
        )
    };
    let message = format!(
        "I of {} is rotated by {:.1}, {:.1}, {:.1} degrees{from} about the axes of J at the design position",
        design.title(kind, header),
        angles.x,
        angles.y,
        angles.z
    );
    found.push(
        design
            .warning(Code::BushingAngle, header, message)
            .help(format!(
                "the angles about x and y must stay below 10 degrees; {help}"
            )),
    );
}
