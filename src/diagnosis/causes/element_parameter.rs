//! `element-parameter`: a deck parameter that the study takes as known is wrong.

use super::super::candidate_effect::{
    CandidateEffect, EffectParameter, Parametrisation, Sensitivity,
};
use super::super::cause::Cause;
use super::super::operating_points::OperatingPoints;
use admire_identify::tolerance::EffectGroup;
use admire_solver::model::SpringKind;
use admire_syntax::Address;

/// Adds candidates for wrong rates and preloads of springs, and for wrong stiffnesses of bushings that the study does not identify.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    for (member, address, group, unit) in survey.numbers_of_the_deck() {
        let sd = match group {
            EffectGroup::Preloads => survey.priors().spring_preload,
            EffectGroup::SpringRates => survey.priors().spring_rate,
            _ => survey.priors().rubber_stiffness,
        };
        let mut hypothesis = CandidateEffect::outstanding(
            Cause::ElementParameter,
            address,
            "",
            [(member, "change".to_string())],
            sd,
        );
        hypothesis.numbers[0].unit = unit;
        out.push(hypothesis);
    }
    free_lengths(survey, out);
}

/// Adds candidates for wrong free lengths of preloaded springs. A wrong free length shifts the force by a constant, as a wrong preload does.
fn free_lengths(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    for (_, address, group, force) in survey.numbers_of_the_deck() {
        if group != EffectGroup::Preloads {
            continue;
        }
        let springs = &survey.model.springdampers;
        let Some(spring) = springs.iter().find(|spring| {
            spring.kind == SpringKind::Translational
                && address == format!("SPRINGDAMPER/{}.FORCE", spring.header.id)
        }) else {
            continue;
        };
        if spring.stiffness <= 0.0 || spring.reference <= 0.0 {
            continue;
        }
        let length = Address::of_argument("SPRINGDAMPER", spring.header.id, "LENGTH", None);
        let change = EffectParameter {
            column: Sensitivity::Always(vec![(length.clone(), 1.0)]),
            ..EffectParameter::new(
                "change",
                survey.priors().spring_preload * force / spring.stiffness,
                Parametrisation::Extended(vec![(length.clone(), 1.0)]),
            )
        };
        let (cause, address) = (Cause::ElementParameter, length.to_string());
        out.push(CandidateEffect::plain(cause, address, "", vec![change]));
    }
}
