//! `link-compliance`: a part deforms along the line of its two joints.
//!
//! The part is split at one of its ends by a bushing that yields along the line only; where the marks sit decides which end.

use crate::mechanics::{Mat3, Vec3, psi_theta_phi};

use super::super::cause::Cause;
use super::super::hypothesis::{Change, Column, Hypothesis, Number, RIGID, Unknown, number};
use super::super::survey::Survey;

/// Millimetres per newton a link may well yield.
const SD: f64 = 1e-4;

/// Every movable part with exactly two attachments.
pub(super) fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    for (part, body) in survey.model.parts.iter().enumerate() {
        let ends = survey.attachments(crate::model::PartIx(part));
        if Some(crate::model::PartIx(part)) == survey.model.ground() || ends.len() != 2 {
            continue;
        }
        let place = |end: usize| survey.model.markers[ends[end].marker.0].qp;
        let line = place(1) - place(0);
        if line.norm() < 1e-6 {
            continue;
        }
        for (end, form) in ["first end", "second end"].into_iter().enumerate() {
            let outward: Vec3 = line.normalize() * if end == 1 { 1.0 } else { -1.0 };
            let marker = survey.marker_id(ends[end].marker);
            let tension: Vec<f64> = (0..survey.cases())
                .map(|case| {
                    let pose = survey.pose(case, crate::model::PartIx(part));
                    ends[end].force[case].dot(&(pose.R * outward))
                })
                .collect();
            let column = (0..3)
                .map(|k| {
                    let shift = tension.iter().map(|n| n * outward[k]).collect();
                    (number("MARKER", marker, "QP", Some(k + 1)), shift)
                })
                .collect();
            let (bushing, changes) =
                split(survey, (body.header.id, part), marker, place(end), &outward);
            out.push(Hypothesis {
                cause: Cause::LinkCompliance,
                address: format!("PART/{}", body.header.id),
                members: Vec::new(),
                side: "",
                form,
                numbers: vec![Number {
                    column: Column::PerCase(column),
                    ..Number::new(
                        "compliance",
                        SD * survey.millimetre() / survey.newton(),
                        Unknown::Compliance(vec![number("BUSHING", bushing, "K", Some(3))]),
                    )
                }],
                ln_prior: 0.0,
                one_sided: true,
                changes,
                memory: None,
                part: 0,
            });
        }
    }
}

/// A marker goes over to a new part, which a bushing with its z axis along `axis` holds to the old one.
fn split(
    survey: &Survey<'_>,
    (part, at): (u32, usize),
    marker: u32,
    place: Vec3,
    axis: &Vec3,
) -> (u32, Vec<Change>) {
    let x = if axis.x.abs() < 0.8 {
        Vec3::x()
    } else {
        Vec3::y()
    };
    let y = axis.cross(&x).normalize();
    let R = Mat3::from_columns(&[y.cross(axis), y, *axis]);
    survey.split(
        (part, crate::model::PartIx(at)),
        marker,
        (place, psi_theta_phi(&R)),
        [RIGID[0], RIGID[0], 1e6],
    )
}
