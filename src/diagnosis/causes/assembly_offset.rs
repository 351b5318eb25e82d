//! `assembly-offset`: the two sides of a bushing are displaced from each other in every load case, compared with the deck.
//!
//! The tolerances already include a translational offset of every bushing, as random effects. The candidate for a translational offset widens
//! their priors, so that the offset may exceed the tolerance. The candidate for a rotational offset adds parameters of its own.

use super::super::candidate_effect::{CandidateEffect, EffectParameter, SIX};
use super::super::cause::Cause;
use super::super::elastic_element::ElasticElement;
use super::super::operating_points::OperatingPoints;
use admire_identify::tolerance::EffectGroup;

/// Adds candidates for a translational and a rotational offset of every bushing or FIELD.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    for element in ElasticElement::all(survey) {
        let address = element.statement();
        let members = survey.members(EffectGroup::Offsets, &address);
        if !members.is_empty() {
            out.push(CandidateEffect::outstanding(
                Cause::AssemblyOffset,
                address.clone(),
                "shift",
                members,
                survey.priors().bushing_offset_mm * survey.millimetre(),
            ));
        }
        let stiff = (3..6).filter(|axis| element.stiffness[*axis] > 0.0);
        let numbers = stiff.filter_map(|axis| {
            let (unknown, column) = element.offset(survey, axis)?;
            let sd = survey.priors().bushing_offset_deg.to_radians();
            Some(EffectParameter {
                column,
                ..EffectParameter::new(SIX[axis], sd, unknown)
            })
        });
        let numbers: Vec<EffectParameter> = numbers.collect();
        if !numbers.is_empty() {
            out.push(CandidateEffect::plain(
                Cause::AssemblyOffset,
                address,
                "turn",
                numbers,
            ));
        }
    }
}
