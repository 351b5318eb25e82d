//! `assembly-offset`: the two sides of a bushing sit displaced from where the deck says, in every load case.
//!
//! Out of centre, askew, or both: six numbers where three do it would lose to a mimic that needs fewer.

use super::super::cause::Cause;
use super::super::survey::Survey;

use super::{Column, Hypothesis, Number, SIX, Unknown, number};

/// Millimetres and degrees a bushing may well be off.
const SD: (f64, f64) = (0.5, 0.5);

/// Bushings whose offset is no unknown of the fit already; the others' are judged by their own estimate.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    for (k, bushing) in survey.model.bushings.iter().enumerate() {
        if bushing.header.active && !survey.offset_is_unknown(k) {
            out.extend(["", "shift", "turn"].map(|form| of_form(survey, k, form)));
        }
    }
}

/// The offset of one bushing, along every component that has a stiffness.
pub fn of_bushing(survey: &Survey<'_>, bushing: usize) -> Hypothesis {
    of_form(survey, bushing, "")
}

fn of_form(survey: &Survey<'_>, bushing: usize, form: &'static str) -> Hypothesis {
    let axes = match form {
        "shift" => 0..3,
        "turn" => 3..6,
        _ => 0..6,
    };
    let id = survey.model.bushings[bushing].header.id;
    let stiffnesses = survey.stiffnesses(bushing);
    let numbers = axes.filter_map(|axis| {
        let (words, sd) = if axis < 3 {
            (["K", "FORCE"], SD.0 * survey.millimetre())
        } else {
            (["KT", "TORQUE"], SD.1.to_radians())
        };
        let [stiffness, preload] =
            words.map(|word| number("BUSHING", id, word, Some(axis % 3 + 1)));
        (stiffnesses[axis] > 0.0).then(|| Number {
            column: Column::Always(vec![(preload.clone(), stiffnesses[axis])]),
            ..Number::new(SIX[axis], sd, Unknown::Offset { stiffness, preload })
        })
    });
    Hypothesis::plain(
        Cause::AssemblyOffset,
        format!("BUSHING/{id}"),
        form,
        numbers.collect(),
    )
}
