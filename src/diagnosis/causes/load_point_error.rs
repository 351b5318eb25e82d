//! `load-point-error`: a load acts at a point other than its marker.

use super::super::candidate_effect::CandidateEffect;
use super::super::cause::Cause;
use super::super::operating_points::OperatingPoints;
use admire_identify::tolerance::EffectGroup;

/// Adds candidates for the displacement of every point where a load acts: along each axis alone, and in all directions together.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    for marker in &survey.model.markers {
        let address = format!("MARKER/{}", marker.header.id);
        let members = survey.members(EffectGroup::LoadPoints, &address);
        let sd = survey.priors().load_point_mm * survey.millimetre();
        for (axis, form) in ["along x", "along y", "along z"].into_iter().enumerate() {
            if let Some(member) = members.get(axis) {
                out.push(CandidateEffect::outstanding(
                    Cause::LoadPointError,
                    address.clone(),
                    form,
                    [member.clone()],
                    sd,
                ));
            }
        }
        if !members.is_empty() {
            out.push(CandidateEffect::outstanding(
                Cause::LoadPointError,
                address,
                "",
                members,
                sd,
            ));
        }
    }
}
