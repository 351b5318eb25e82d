//! `bushing-coupling`: off-diagonal stiffness of a conical or inclined bushing, constant or growing with the deflection.

use admire_solver::mechanics::Vec6;
use admire_syntax::{Address, Expression, NewStatement};

use super::super::candidate_effect::{
    CandidateEffect, Change, EffectParameter, FORCES, Parametrisation, Sensitivity, Term,
};
use super::super::cause::Cause;
use super::super::elastic_element::ElasticElement;
use super::super::operating_points::OperatingPoints;
use crate::settings::ROUND_OFF_DEFLECTION;

/// Pairs of coupled components with their names. Components 0 to 2 are translations, components 3 to 5 rotations.
const PAIRS: [(usize, usize, &str); 15] = [
    (0, 1, "x-y"),
    (0, 2, "x-z"),
    (1, 2, "y-z"),
    (0, 3, "x-rx"),
    (0, 4, "x-ry"),
    (0, 5, "x-rz"),
    (1, 3, "y-rx"),
    (1, 4, "y-ry"),
    (1, 5, "y-rz"),
    (2, 3, "z-rx"),
    (2, 4, "z-ry"),
    (2, 5, "z-rz"),
    (3, 4, "rx-ry"),
    (3, 5, "rx-rz"),
    (4, 5, "ry-rz"),
];

/// Adds candidates for a coupling between every pair of components of every bushing or FIELD.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    for element in ElasticElement::all(survey) {
        let (stiffness, pair) = (element.stiffness, element.pair);
        let [i, j] = [pair.0, pair.1].map(|marker| survey.marker_id(marker).to_string());
        let field = survey.free_id("FIELD");
        for (a, b, form) in PAIRS {
            let size = (stiffness[a] * stiffness[b]).max(0.0).sqrt();
            if size <= 0.0 {
                continue;
            }
            let wrench = element
                .deflections
                .iter()
                .map(|u| {
                    let mut w = Vec6::zeros();
                    w[a] = -u[b];
                    w[b] = -u[a];
                    w
                })
                .collect();
            let entry = |row: usize, column: usize| {
                (
                    Address::of_argument("FIELD", field, "KMATRIX", Some(6 * column + row + 1)),
                    1.0,
                )
            };
            let statement = NewStatement {
                kind: "FIELD".to_string(),
                id: Some(field),
                view_name: None,
                arguments: vec![
                    ("I".to_string(), Some(i.clone())),
                    ("J".to_string(), Some(j.clone())),
                    ("KMATRIX".to_string(), Some(["0.0"; 36].join(", "))),
                    ("CMATRIX".to_string(), Some(["0.0"; 36].join(", "))),
                ],
            };
            out.push(CandidateEffect {
                cause: Cause::BushingCoupling,
                address: element.statement(),
                members: Vec::new(),
                side: "",
                form,
                numbers: vec![EffectParameter {
                    column: Sensitivity::Wrench(pair, wrench),
                    ..EffectParameter::new(
                        form,
                        survey.priors().bushing_coupling * size,
                        Parametrisation::Extended(vec![entry(a, b), entry(b, a)]),
                    )
                }],
                ln_prior: 0.0,
                one_sided: false,
                changes: vec![Change::Add(statement)],
                memory: None,
                term: Term::Main,
                joint_with: None,
            });
        }
    }
}

/// Returns the term by which a coupling in the model grows with the deflection. The energy `k u_a u_b` gains the terms `c u_a u_b^3` and `d
/// u_a^3 u_b`. These are the next terms of an energy that is even in the deflections.
pub(crate) fn growth(
    survey: &OperatingPoints<'_>,
    constant: &CandidateEffect,
) -> Option<CandidateEffect> {
    let (a, b, form) = *PAIRS.iter().find(|(.., form)| *form == constant.form)?;
    if constant.cause != Cause::BushingCoupling {
        return None;
    }
    let mut elements = ElasticElement::all(survey).into_iter();
    let element = elements.find(|element| element.statement() == constant.address)?;
    let (pair, deflections) = (element.pair, element.deflections);
    let largest = |axis: usize| {
        deflections
            .iter()
            .fold(0.0_f64, |most, u| most.max(u[axis].abs()))
    };
    let (far_a, far_b) = (largest(a), largest(b));
    if far_a.min(far_b) < ROUND_OFF_DEFLECTION {
        return None;
    }
    let [u, v] = [a, b].map(|axis| survey.deflection_function(pair, axis));
    // Functions of the forces along a and b, for each of the two energy terms.
    let terms = [
        [format!("-0.0*{v}**3"), format!("-0.0*3*{u}*{v}**2")],
        [format!("-0.0*3*{u}**2*{v}"), format!("-0.0*{u}**3")],
    ];
    let texts = [0, 1].map(|side| format!("{}{}", terms[0][side], terms[1][side]));
    let (force, changes) = survey.vector_force(pair, &[(a, &texts[0]), (b, &texts[1])]);
    let literal = |side: usize, term: usize| {
        let before = |term: &[String; 2]| {
            Expression::parse_str(&term[side]).map_or(0, |text| text.literals.len())
        };
        let first: usize = terms[..term].iter().map(before).sum();
        Address::of_argument("GFORCE", force, FORCES[[a, b][side]], Some(1 + first))
    };
    let along = |rise: &dyn Fn(f64, f64) -> [f64; 2]| {
        let of = |u: &[f64; 6]| {
            let mut w = Vec6::zeros();
            [w[a], w[b]] = rise(u[a], u[b]).map(|force| -force);
            w
        };
        deflections.iter().map(of).collect()
    };
    let rises: [&dyn Fn(f64, f64) -> [f64; 2]; 2] =
        [&|u, v| [v.powi(3), 3.0 * u * v * v], &|u, v| {
            [3.0 * u * u * v, u.powi(3)]
        }];
    let (first, second) = form.split_once('-')?;
    let names = [
        format!("{first}-{second}{second}{second}"),
        format!("{first}{first}{first}-{second}"),
    ];
    // The prior allows a force at the largest deflection as large as the force of the constant coupling.
    let numbers = names
        .into_iter()
        .enumerate()
        .map(|(k, name)| EffectParameter {
            column: Sensitivity::Wrench(pair, along(rises[k])),
            ..EffectParameter::new(
                name,
                constant.numbers[0].sd / [far_b, far_a][k].powi(2),
                Parametrisation::Extended(vec![(literal(0, k), 1.0), (literal(1, k), 1.0)]),
            )
        });
    let mut growth = CandidateEffect::plain(
        Cause::BushingCoupling,
        constant.address.clone(),
        form,
        numbers.collect(),
    );
    growth.changes = changes.into_iter().map(Change::Add).collect();
    growth.term = Term::Further(1);
    growth.ln_prior = libm::log(survey.priors().growing_coupling);
    Some(growth)
}
