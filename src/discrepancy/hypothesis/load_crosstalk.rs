//! `load-crosstalk`: the rig applies part of one load along another.
//!
//! Nine of them mimic almost anything, so each carries a prior of rig quality and stands for itself.

use super::super::cause::Cause;
use super::super::survey::Survey;

use super::{Column, Hypothesis, Number};

/// Rigs keep cross-talk to a few percent.
const SD: f64 = 0.02;

/// Every ordered pair of loads.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    let loads = survey.loads();
    for to in loads.iter().filter(|load| survey.is_force(load)) {
        for (k, from) in loads.iter().enumerate() {
            if from.target == to.target || !survey.is_force(from) {
                continue;
            }
            let column = Column::PerCase(vec![(to.target.clone(), survey.load_values(k))]);
            out.push(Hypothesis::plain(
                Cause::LoadCrosstalk,
                format!("{}<-{}", to.target, from.target),
                "",
                vec![Number::linear("fraction", SD, column)],
            ));
        }
    }
}
