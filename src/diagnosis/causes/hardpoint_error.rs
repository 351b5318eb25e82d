//! `hardpoint-error`: the location of a connection point differs from the deck.
//!
//! In the form `point`, a hardpoint of the car is displaced: all parts that meet there move together, and nothing is strained. In the form
//! `part`, only one side is displaced: a part was made wrong and is assembled under strain. For a bushing, a displaced side is
//! `assembly-offset`.

use super::super::candidate_effect::{CandidateEffect, EffectParameter, SIX, Sensitivity};
use super::super::cause::Cause;
use super::super::operating_points::OperatingPoints;
use admire_identify::tolerance::EffectGroup;
use admire_solver::mechanics::Vec3;
use admire_solver::model::MarkerIx;
use admire_syntax::Address;

/// Adds candidates for the displacement of every hardpoint, in all directions together and along each axis alone, and of every end of a
/// joint, primitive or spring.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    let model = survey.model;
    for point in survey.points() {
        let names = point
            .markers
            .iter()
            .map(|marker| marker_name(survey, *marker));
        let names: Vec<String> = names.collect();
        let members = survey.members(EffectGroup::Hardpoints, &names[0]);
        let mut put = |form, members: Vec<(usize, String)>| {
            if !members.is_empty() {
                let sd = survey.priors().hardpoint_mm * survey.millimetre();
                out.push(CandidateEffect {
                    members: names.clone(),
                    side: "point",
                    ..CandidateEffect::outstanding(
                        Cause::HardpointError,
                        names[0].clone(),
                        form,
                        members,
                        sd,
                    )
                });
            }
        };
        // A coordinate that the study identifies is not among the members.
        for own in &members {
            let axis = survey.subject.layer.members[own.0].axis;
            put(["along x", "along y", "along z"][axis], vec![own.clone()]);
        }
        put("", members);
    }
    let joints = model
        .joints
        .iter()
        .map(|joint| (&joint.header, joint.i, joint.j));
    let primitives = model.primitives.iter().map(|p| (&p.header, p.i, p.j));
    let springs = model.springdampers.iter().map(|s| (&s.header, s.i, s.j));
    let mut seen = Vec::new();
    for (header, i, j) in joints.chain(primitives).chain(springs) {
        for marker in [i, j] {
            // If no other marker coincides with this end, the end is a hardpoint by itself.
            let alone = survey
                .points()
                .iter()
                .any(|point| point.markers == [marker]);
            if !header.active || seen.contains(&marker) || alone {
                continue;
            }
            seen.push(marker);
            let own = &model.markers[marker.0];
            let id = own.header.id;
            let numbers = (0..3).map(|k| {
                let unit = own.as_written(&Vec3::ith(k, 1.0));
                let column = (0..3)
                    .filter(|c| unit[*c] != 0.0)
                    .map(|c| {
                        (
                            Address::of_argument("MARKER", id, "QP", Some(c + 1)),
                            unit[c],
                        )
                    })
                    .collect();
                let sd = survey.priors().part_end_mm * survey.millimetre();
                EffectParameter::linear(SIX[k], sd, Sensitivity::Always(column))
            });
            out.push(CandidateEffect {
                side: "part",
                ..CandidateEffect::plain(
                    Cause::HardpointError,
                    format!("MARKER/{id}"),
                    "one side",
                    numbers.collect(),
                )
            });
        }
    }
}

fn marker_name(survey: &OperatingPoints<'_>, marker: MarkerIx) -> String {
    format!("MARKER/{}", survey.marker_id(marker))
}
