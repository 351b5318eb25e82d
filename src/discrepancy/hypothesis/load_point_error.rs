//! `load-point-error`: a load acts elsewhere than at its marker.

use super::super::cause::Cause;
use super::super::survey::Survey;

use super::{Column, Hypothesis, Number, SIX, number};

/// Millimetres a contact patch may well be off.
const SD: f64 = 8.0;

/// The I marker of every driven force, once.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    let model = survey.model;
    let mut seen = Vec::new();
    for load in survey.loads() {
        let id = load.target.id.unwrap_or_default();
        let marker = match load.target.kind.as_str() {
            "SFORCE" => model
                .sforces
                .iter()
                .find(|f| f.header.id == id)
                .map(|f| f.i),
            "GFORCE" | "VFORCE" | "VTORQUE" => model
                .vector_forces
                .iter()
                .find(|f| f.header.id == id)
                .map(|f| f.i),
            _ => None,
        };
        let Some(marker) = marker.filter(|marker| !seen.contains(marker)) else {
            continue;
        };
        seen.push(marker);
        let id = model.markers[marker.0].header.id;
        let numbers = (0..3).map(|k| {
            let slot = number("MARKER", id, "QP", Some(k + 1));
            let sd = SD * survey.millimetre();
            Number::linear(SIX[k], sd, Column::Always(vec![(slot, 1.0)]))
        });
        out.push(Hypothesis::plain(
            Cause::LoadPointError,
            format!("MARKER/{id}"),
            "",
            numbers.collect(),
        ));
    }
}
