//! `bushing-coupling`: off-diagonal stiffness, as of a conical or inclined bushing.

use crate::mechanics::Vec6;
use crate::syntax::NewStatement;

use super::super::cause::Cause;
use super::super::hypothesis::{Change, Column, Hypothesis, Number, Unknown, number};
use super::super::survey::Survey;

/// Names of the fifteen pairs.
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

/// Every pair of components of every bushing.
pub(super) fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    for (at, bushing) in survey.model.bushings.iter().enumerate() {
        if !bushing.header.active {
            continue;
        }
        let id = bushing.header.id;
        let deflections = survey.bushing_deflections(at);
        let stiffness = survey.stiffnesses(at);
        let field = survey.free_id("FIELD");
        for (a, b, form) in PAIRS {
            let size = (stiffness[a] * stiffness[b]).max(0.0).sqrt();
            if size <= 0.0 {
                continue;
            }
            let wrench = deflections
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
                    number("FIELD", field, "KMATRIX", Some(6 * column + row + 1)),
                    1.0,
                )
            };
            let statement = NewStatement {
                kind: "FIELD".to_string(),
                id: Some(field),
                view_name: None,
                arguments: vec![
                    (
                        "I".to_string(),
                        Some(survey.marker_id(bushing.i).to_string()),
                    ),
                    (
                        "J".to_string(),
                        Some(survey.marker_id(bushing.j).to_string()),
                    ),
                    ("KMATRIX".to_string(), Some(["0.0"; 36].join(", "))),
                    ("CMATRIX".to_string(), Some(["0.0"; 36].join(", "))),
                ],
            };
            out.push(Hypothesis {
                cause: Cause::BushingCoupling,
                address: format!("BUSHING/{id}"),
                members: Vec::new(),
                side: "",
                form,
                numbers: vec![Number {
                    column: Column::Wrench((bushing.i, bushing.j), wrench),
                    ..Number::new(
                        form,
                        0.1 * size,
                        Unknown::Extended(vec![entry(a, b), entry(b, a)]),
                    )
                }],
                ln_prior: 0.0,
                one_sided: false,
                changes: vec![Change::Add(statement)],
                memory: None,
                part: 0,
            });
        }
    }
}
