//! `bushing-orientation`: the bushing is mounted with a rotation. Both sides rotate together, so that no preload arises.

use super::super::candidate_effect::{CandidateEffect, SIX};
use super::super::cause::Cause;
use super::super::elastic_element::ElasticElement;
use super::super::operating_points::OperatingPoints;
use admire_identify::tolerance::EffectGroup;

/// Adds candidates for the rotation of every bushing or FIELD: about each of its axes alone, and about all axes together.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    for element in ElasticElement::all(survey) {
        let address = element.statement();
        let members = survey.members(EffectGroup::Axes, &address).into_iter();
        let angles: Vec<(usize, String)> = members
            .zip(SIX)
            .map(|((member, _), axis)| (member, format!("angle_{axis}")))
            .collect();
        let mut form = |name, angles: Vec<(usize, String)>| {
            let cause = Cause::BushingOrientation;
            out.push(CandidateEffect::outstanding(
                cause,
                address.clone(),
                name,
                angles,
                survey.priors().bushing_orientation_deg.to_radians(),
            ));
        };
        for (angle, axis) in angles.iter().zip(SIX) {
            form(axis, vec![angle.clone()]);
        }
        if angles.len() > 1 {
            form("", angles);
        }
    }
}
