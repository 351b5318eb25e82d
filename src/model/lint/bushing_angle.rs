use super::Design;
use crate::diagnostic::{Code, Diagnostic};
use crate::mechanics::projected_angles;
use crate::model::{Header, MarkerIx};

/// Beyond this the projected angles are no longer the components of a rotation.
const LARGEST: f64 = 10.0;

/// Bushings, beams and fields whose markers are turned against each other about x or y at the design position. About z alone
/// a large angle does no harm (ADAMS-FORMATS 2.7).
pub(super) fn check(design: &Design<'_>, found: &mut Vec<Diagnostic>) {
    let model = design.model;
    for bushing in &model.bushings {
        if bushing.kt != [0.0; 3] {
            pair(
                design,
                "BUSHING",
                &bushing.header,
                bushing.i,
                bushing.j,
                found,
            );
        }
    }
    for beam in &model.beams {
        pair(design, "BEAM", &beam.header, beam.i, beam.j, found);
    }
    for field in &model.fields {
        pair(design, "FIELD", &field.header, field.i, field.j, found);
    }
}

fn pair(
    design: &Design<'_>,
    kind: &str,
    header: &Header,
    i: MarkerIx,
    j: MarkerIx,
    found: &mut Vec<Diagnostic>,
) {
    let Some((i, j)) = design.pair(i, j) else {
        return;
    };
    let angles = projected_angles(&(j.R.transpose() * i.R)).map(f64::to_degrees);
    let largest = angles.x.abs().max(angles.y.abs());
    if largest <= LARGEST {
        return;
    }
    let message = format!(
        "I of {} is turned by {:.1}, {:.1}, {:.1} degrees about the axes of J at the design position",
        design.title(kind, header),
        angles.x,
        angles.y,
        angles.z
    );
    found.push(
        design
            .warning(Code::BushingAngle, header, message)
            .help("angles about x and y must stay below 10 degrees; give I the orientation of J"),
    );
}
