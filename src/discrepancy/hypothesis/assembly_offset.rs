//! `assembly-offset`: the two sides of a bushing sit displaced from where the deck says, in every load case.

use super::super::cause::Cause;
use super::super::survey::Survey;

use super::{Column, Hypothesis, Number, SIX, number};

/// Millimetres and degrees a bushing may well be off.
const SD: (f64, f64) = (0.5, 0.5);

/// Bushings whose offset is no unknown of the fit already; the others' are judged by their own estimate.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    for (k, bushing) in survey.model.bushings.iter().enumerate() {
        if !bushing.header.active || survey.offset_is_unknown(k) {
            continue;
        }
        let id = bushing.header.id;
        let numbers = (0..6).filter_map(|axis| {
            let (words, stiffness, sd) = if axis < 3 {
                ("FORCE", bushing.k[axis], SD.0 * survey.millimetre())
            } else {
                ("TORQUE", bushing.kt[axis - 3], SD.1.to_radians())
            };
            let slot = number("BUSHING", id, words, Some(axis % 3 + 1));
            (stiffness > 0.0)
                .then(|| Number::linear(SIX[axis], sd, Column::Always(vec![(slot, stiffness)])))
        });
        out.push(Hypothesis::plain(
            Cause::AssemblyOffset,
            format!("BUSHING/{id}"),
            "",
            numbers.collect(),
        ));
    }
}
