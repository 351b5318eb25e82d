//! `body-compliance`: the ground-side attachment of a joint or spring yields.
//!
//! For a bushing, the compliance of its attachment is part of the identified stiffness.

use admire_solver::mechanics::Vec3;
use admire_solver::model::MarkerIx;

use super::super::candidate_effect::{
    CandidateEffect, EffectParameter, Parametrisation, Sensitivity, Term,
};
use super::super::cause::Cause;
use super::super::operating_points::OperatingPoints;
use crate::settings::SPLIT_STIFFNESS_N_PER_MM;
use admire_syntax::Address;

/// Name of the form in which the attachment holds a link: a part with exactly two attachments. Along the link, such a compliance is
/// indistinguishable from compliance of the link.
pub(super) const IN_LINE: &str = "holds a link";

/// Adds candidates for the compliance of the ground-side attachment of joints and springs, equal in all directions.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    let model = survey.model;
    let Some(ground) = model.ground() else {
        return;
    };
    let per_length = survey.newton() / survey.millimetre();
    let mut put =
        |address: String, (i, j): (MarkerIx, MarkerIx), forces: Vec<[Vec3; 2]>, sd: f64| {
            let sides = [i, j].map(|marker| model.markers[marker.0].part == ground);
            let side = match sides {
                [true, false] => 0,
                [false, true] => 1,
                _ => return,
            };
            let marker = [i, j][side];
            let id = survey.marker_id(marker);
            let R = model.parts[ground.0].pose.R;
            let own = &model.markers[marker.0];
            let shifts = forces.iter();
            let shifts: Vec<Vec3> = shifts
                .map(|f| own.as_written(&(R.transpose() * f[side])))
                .collect();
            let column = (0..3)
                .map(|k| {
                    let slot = Address::of_argument("MARKER", id, "QP", Some(k + 1));
                    (slot, shifts.iter().map(|s| s[k]).collect())
                })
                .collect();
            let ground = model.parts[ground.0].header.id;
            let (bushing, _, changes) = survey.split(
                ground,
                id,
                own.qp,
                [0.0; 3],
                [SPLIT_STIFFNESS_N_PER_MM * per_length; 3],
            );
            let stiffnesses =
                (1..=3).map(|k| Address::of_argument("BUSHING", bushing, "K", Some(k)));
            out.push(CandidateEffect {
                cause: Cause::BodyCompliance,
                address,
                members: Vec::new(),
                side: "",
                form: if survey.attachments(model.markers[[j, i][side].0].part).len() == 2 {
                    IN_LINE
                } else {
                    ""
                },
                numbers: vec![EffectParameter {
                    column: Sensitivity::PerCase(column),
                    ..EffectParameter::new(
                        "compliance",
                        sd / per_length,
                        Parametrisation::Compliance(stiffnesses.collect()),
                    )
                }],
                ln_prior: 0.0,
                one_sided: true,
                changes,
                memory: None,
                term: Term::Main,
                joint_with: None,
            });
        };
    for joint in model.joints.iter().filter(|j| j.header.active) {
        let readings = survey.constraint("JOINT", joint.header.id);
        let forces = readings.iter().map(|r| [r.force, r.force_on_j]).collect();
        put(
            format!("JOINT/{}", joint.header.id),
            (joint.i, joint.j),
            forces,
            survey.priors().body_compliance_mm_per_n,
        );
    }
    for spring in model.springdampers.iter().filter(|s| s.header.active) {
        let readings = survey.element("SPRINGDAMPER", spring.header.id);
        let forces = readings.iter().map(|r| [r.force, r.force_on_j]).collect();
        put(
            format!("SPRINGDAMPER/{}", spring.header.id),
            (spring.i, spring.j),
            forces,
            survey.priors().spring_seat_compliance_mm_per_n,
        );
    }
}
