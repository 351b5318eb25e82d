//! `load-gain`: the rig's load is wrong by a factor.

use super::super::cause::Cause;
use super::super::survey::Survey;

use super::{Column, Hypothesis, Number};

/// A load cell may well be wrong by so much.
const SD: f64 = 0.05;

/// Every load of the study.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    for (k, load) in survey.loads().iter().enumerate() {
        if !survey.is_force(load) {
            continue;
        }
        let values = survey.load_values(k);
        let column = Column::PerCase(vec![(load.target.clone(), values)]);
        out.push(Hypothesis::plain(
            Cause::LoadGain,
            load.target.to_string(),
            "",
            vec![Number::linear("gain", SD, column)],
        ));
    }
}
