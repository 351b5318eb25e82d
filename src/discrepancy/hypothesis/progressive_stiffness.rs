//! `progressive-stiffness`: force grows faster than linearly with a deflection.

use crate::mechanics::Vec6;

use super::super::cause::Cause;
use super::super::survey::Survey;

use super::{Change, Column, Hypothesis, Number, Unknown, number};

/// Every component of every bushing: a cubic and a quadratic term beside its stiffness.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    for (k, bushing) in survey.model.bushings.iter().enumerate() {
        if !bushing.header.active {
            continue;
        }
        let id = bushing.header.id;
        let deflections = survey.bushing_deflections(k);
        let stiffness = survey.stiffnesses(k);
        for axis in 0..6 {
            let u: Vec<f64> = deflections.iter().map(|d| d[axis]).collect();
            let largest = u.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
            if largest < 1e-9 || stiffness[axis] <= 0.0 {
                continue;
            }
            let measure = survey.deflection_function((bushing.i, bushing.j), axis);
            for form in ["cubic", "quadratic"] {
                let (text, power): (String, fn(f64) -> f64) = if form == "cubic" {
                    (format!("0.0*{measure}**3"), |u| u * u * u)
                } else {
                    (format!("0.0*{measure}*ABS({measure})"), |u| u * u.abs())
                };
                let wrench = u.iter().map(|u| Vec6::ith(axis, -power(*u))).collect();
                let (gforce, changes) = survey.vector_force((bushing.i, bushing.j), axis, &text);
                let address = number("GFORCE", gforce, super::FORCES[axis], Some(1));
                out.push(Hypothesis {
                    cause: Cause::ProgressiveStiffness,
                    address: format!("BUSHING/{id}.{}", super::component(axis)),
                    form,
                    numbers: vec![Number {
                        name: form.to_string(),
                        sd: 3.0 * stiffness[axis] * largest / power(largest),
                        column: Column::Wrench((bushing.i, bushing.j), wrench),
                        unknown: Unknown::Extended(vec![(address, -1.0)]),
                    }],
                    one_sided: true,
                    changes: changes.into_iter().map(Change::Add).collect(),
                });
            }
        }
    }
}
