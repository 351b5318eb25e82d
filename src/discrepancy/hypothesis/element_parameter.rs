//! `element-parameter`: a number of the deck taken as known is wrong.

use crate::syntax::Address;

use super::super::cause::Cause;
use super::super::survey::Survey;

use super::{Column, Hypothesis, Number, number};

/// A steel spring taken as known may well be wrong by this part of itself,
const RELATIVE: f64 = 0.2;
/// and rubber by this one: data sheets often give its dynamic stiffness, which is half as large again.
const RUBBER: f64 = 0.4;

/// Rates, preloads and lengths of springs, and stiffnesses of bushings that are not identified.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    let model = survey.model;
    let mut put = |address: Address, sd: f64| {
        if survey.is_identified(&address) || sd <= 0.0 {
            return;
        }
        let column = Column::Always(vec![(address.clone(), 1.0)]);
        out.push(Hypothesis::plain(
            Cause::ElementParameter,
            address.to_string(),
            "",
            vec![Number::linear("change", sd, column)],
        ));
    };
    for spring in model.springdampers.iter().filter(|s| s.header.active) {
        let id = spring.header.id;
        let preload = spring
            .preload
            .abs()
            .max(spring.stiffness * spring.reference * 0.1);
        put(
            number("SPRINGDAMPER", id, "K", None),
            RELATIVE * spring.stiffness,
        );
        put(
            number("SPRINGDAMPER", id, "FORCE", None),
            RELATIVE * preload,
        );
        if spring.stiffness > 0.0 {
            let length = RELATIVE * preload / spring.stiffness;
            put(number("SPRINGDAMPER", id, "LENGTH", None), length);
        }
    }
    for bushing in model.bushings.iter().filter(|b| b.header.active) {
        for axis in 0..3 {
            let id = bushing.header.id;
            put(
                number("BUSHING", id, "K", Some(axis + 1)),
                RUBBER * bushing.k[axis],
            );
            put(
                number("BUSHING", id, "KT", Some(axis + 1)),
                RUBBER * bushing.kt[axis],
            );
        }
    }
}
