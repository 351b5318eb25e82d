//! `assembly-offset`: the two sides of a bushing are displaced from each other in every load case, compared with the deck.
//!
//! The translational offset of every bushing is a random effect. It becomes a finding if it exceeds its tolerance group. A rotational offset
//! is a separate effect.

use super::super::candidate_effect::{
    CandidateEffect, EffectParameter, Parametrisation, SIX, Sensitivity, number,
};
use super::super::cause::Cause;
use super::super::elastic_element::bushing_stiffness;
use super::super::operating_points::OperatingPoints;
use admire_identify::tolerance::EffectGroup;

/// Adds candidates for a translational and a rotational offset of every bushing.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    for (k, bushing) in survey.model.bushings.iter().enumerate() {
        if !bushing.header.active {
            continue;
        }
        let id = bushing.header.id;
        let address = format!("BUSHING/{id}");
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
        let stiffnesses = bushing_stiffness(survey, k);
        let numbers = (3..6).filter(|axis| stiffnesses[*axis] > 0.0).map(|axis| {
            let [stiffness, preload] =
                ["KT", "TORQUE"].map(|word| number("BUSHING", id, word, Some(axis - 2)));
            let column = Sensitivity::Always(vec![(preload.clone(), stiffnesses[axis])]);
            EffectParameter {
                column,
                ..EffectParameter::new(
                    SIX[axis],
                    survey.priors().bushing_offset_deg.to_radians(),
                    Parametrisation::Offset { stiffness, preload },
                )
            }
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
