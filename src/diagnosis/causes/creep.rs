//! `creep`: rubber flows from case to case. The force is `F = -K (u - c)` with the deflection `u`. In every case, `c` covers a fraction of
//! its distance to `u`.

use admire_identify::global::Evolution;
use admire_solver::mechanics::Vec6;

use super::super::candidate_effect::{
    CandidateEffect, Change, EffectParameter, FORCES, MemoryPlan, Parametrisation, Sensitivity,
    Term,
};
use super::super::cause::Cause;
use super::super::elastic_element::ElasticElement;
use super::super::operating_points::{OperatingPoints, statement};
use crate::settings::START_CREEP_RATES;
use admire_syntax::Address;

/// Names of the first guesses of the creep rate.
const FORMS: [&str; 3] = ["slow", "middle", "fast"];

/// Adds candidates for creep in every component of every elastic element.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    for element in ElasticElement::all(survey) {
        let (pair, stiffness) = (element.pair, element.stiffness);
        for axis in (0..6).filter(|axis| stiffness[*axis] > 0.0) {
            let (place, flow) = (survey.free_id("VARIABLE"), survey.free_id("VARIABLE") + 1);
            let law = format!("0.0*VARVAL({place})");
            let (force, added) = survey.vector_force(pair, &[(axis, &law)]);
            let literal = |id| Address::of_argument("VARIABLE", id, "FUNCTION", Some(1));
            for (rate, form) in START_CREEP_RATES.into_iter().zip(FORMS) {
                let mut flown = 0.0;
                let forces = element.deflections.iter().map(|deflection| {
                    let force = flown;
                    flown += rate * (deflection[axis] - flown);
                    Vec6::ith(axis, force)
                });
                let share = EffectParameter {
                    column: Sensitivity::Wrench(pair, forces.collect()),
                    ..EffectParameter::new(
                        "stiffness",
                        survey.priors().creep_share * stiffness[axis],
                        Parametrisation::Extended(vec![(
                            Address::of_argument("GFORCE", force, FORCES[axis], Some(1)),
                            1.0,
                        )]),
                    )
                };
                let part = EffectParameter {
                    mean: rate,
                    ..EffectParameter::new(
                        "rate",
                        survey.priors().creep_rate,
                        Parametrisation::Extended(vec![(literal(flow), 1.0)]),
                    )
                };
                let variable =
                    |id, value: String| statement("VARIABLE", id, &[("FUNCTION", value)]);
                let new = [
                    variable(place, "0.0".to_string()),
                    // The prior mean of the creep rate is added to this zero.
                    variable(flow, "0.0".to_string()),
                ];
                let address = element.address(axis);
                let plain = CandidateEffect::plain(Cause::Creep, address, form, vec![share, part]);
                out.push(CandidateEffect {
                    one_sided: true,
                    changes: new
                        .into_iter()
                        .chain(added.clone())
                        .map(Change::Add)
                        .collect(),
                    term: Term::Main,
                    joint_with: None,
                    memory: Some(MemoryPlan {
                        anchor: literal(place),
                        carries: Evolution::Flow,
                        by: literal(flow),
                        measure: survey.deflection_function(pair, axis),
                    }),
                    ..plain
                });
            }
        }
    }
}
