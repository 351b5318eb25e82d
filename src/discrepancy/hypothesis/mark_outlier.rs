//! `mark-outlier`: one mark reading is wrong.

use crate::identify::global::Row;

use super::super::cause::Cause;
use super::super::survey::Survey;

use super::{Column, Hypothesis, Number, SIX};

/// Millimetres a misread mark may well be off.
const SD: f64 = 2.0;

/// Every reading of every mark.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    let measurement = survey.measurement;
    for (at, row) in survey.rows().iter().enumerate() {
        let Row::Mark {
            case,
            reading,
            axis: 0,
        } = *row
        else {
            continue;
        };
        let read = measurement.cases[case].marks[reading];
        let part = &measurement.parts[read.part];
        let numbers = (0..3).map(|k| {
            let column = Column::Rows(vec![(at + k, -1.0 / survey.sigma())]);
            Number::linear(SIX[k], SD * survey.millimetre(), column)
        });
        let label = &measurement.cases[case].label;
        out.push(Hypothesis::plain(
            Cause::MarkOutlier,
            format!("case {label} {} {}", part.name, part.marks[read.mark].label),
            "",
            numbers.collect(),
        ));
    }
}
