//! `progressive-stiffness`: the force in a bushing component grows faster than linearly with the deflection.

use admire_solver::mechanics::Vec6;

use super::super::candidate_effect::{
    CandidateEffect, Change, EffectParameter, Parametrisation, Sensitivity, Term,
};
use super::super::cause::Cause;
use super::super::elastic_element::ElasticElement;
use super::super::operating_points::OperatingPoints;
use admire_syntax::Address;

/// Forms of the law: name, and powers of the deflection that are added to the linear term. Every added force is odd in the deflection.
const FORMS: [(&str, &[i32]); 3] = [
    ("cubic", &[3]),
    ("quadratic", &[2]),
    ("cubic and quintic", &[3, 5]),
];

/// Adds candidates for a progressive law in every component of every elastic element.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    for element in ElasticElement::all(survey) {
        let (pair, stiffness) = (element.pair, element.stiffness);
        for axis in 0..6 {
            let u: Vec<f64> = element.deflections.iter().map(|d| d[axis]).collect();
            let largest = u.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
            if largest < 1e-9 || stiffness[axis] <= 0.0 {
                continue;
            }
            let measure = survey.deflection_function(pair, axis);
            for (form, powers) in FORMS {
                let terms: Vec<String> = powers
                    .iter()
                    .map(|power| match power {
                        2 => format!("-0.0*{measure}*ABS({measure})"),
                        _ => format!("-0.0*{measure}**{power}"),
                    })
                    .collect();
                let text = terms.concat();
                let (gforce, changes) = survey.vector_force(pair, &[(axis, &text)]);
                // All terms have the same number of literals: the factor, the marker ids, and the power if it is written as a literal.
                let each = admire_syntax::Expression::parse_str(&text)
                    .map_or(0, |text| text.literals.len())
                    / powers.len();
                let numbers = powers.iter().enumerate().map(|(k, &power)| {
                    let rise = |u: f64| match power {
                        2 => u * u.abs(),
                        _ => u.powi(power),
                    };
                    let wrench = u.iter().map(|u| Vec6::ith(axis, -rise(*u))).collect();
                    let literal = Some(1 + each * k);
                    let address = Address::of_argument(
                        "GFORCE",
                        gforce,
                        super::super::candidate_effect::FORCES[axis],
                        literal,
                    );
                    EffectParameter {
                        column: Sensitivity::Wrench(pair, wrench),
                        ..EffectParameter::new(
                            ["", "", "quadratic", "cubic", "", "quintic"][power as usize],
                            survey.priors().progressive_stiffness * stiffness[axis] * largest
                                / rise(largest),
                            Parametrisation::Extended(vec![(address, 1.0)]),
                        )
                    }
                });
                out.push(CandidateEffect {
                    cause: Cause::ProgressiveStiffness,
                    address: element.address(axis),
                    members: Vec::new(),
                    side: "",
                    form,
                    numbers: numbers.collect(),
                    ln_prior: 0.0,
                    one_sided: powers.len() == 1,
                    changes: changes.into_iter().map(Change::Add).collect(),
                    memory: None,
                    term: Term::Main,
                    joint_with: None,
                });
            }
        }
    }
}
