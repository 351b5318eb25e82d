//! `frame-drift`: the measuring frame moved in one load case.

use crate::identify::global::Row;
use crate::mechanics::Vec3;

use super::super::cause::Cause;
use super::super::hypothesis::{Column, Hypothesis, Number, SIX};
use super::super::survey::Survey;

/// Millimetres and degrees a frame may well move.
const SD: (f64, f64) = (0.2, 0.03);

/// Every load case with marks: a shift and a turn about the centroid of its marks.
pub(super) fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    let measurement = survey.measurement;
    for (case, read) in measurement.cases.iter().enumerate() {
        // Three marks leave no freedom beyond the six.
        if read.marks.len() < 4 {
            continue;
        }
        let centroid = read.marks.iter().map(|m| m.x).sum::<Vec3>() / read.marks.len() as f64;
        let mut columns = vec![Vec::new(); 6];
        for (at, row) in survey.rows().iter().enumerate() {
            let Row::Mark {
                case: of,
                reading,
                axis,
            } = *row
            else {
                continue;
            };
            if of != case {
                continue;
            }
            let lever = read.marks[reading].x - centroid;
            for k in 0..3 {
                let turn = Vec3::ith(k, 1.0).cross(&lever);
                if k == axis {
                    columns[k].push((at, 1.0 / survey.sigma()));
                }
                columns[3 + k].push((at, turn[axis] / survey.sigma()));
            }
        }
        let numbers = columns.into_iter().enumerate().map(|(k, rows)| {
            let sd = if k < 3 {
                SD.0 * survey.millimetre()
            } else {
                SD.1.to_radians()
            };
            Number::linear(SIX[k], sd, Column::Rows(rows))
        });
        out.push(Hypothesis::plain(
            Cause::FrameDrift,
            format!("case {}", read.label),
            "",
            numbers.collect(),
        ));
    }
}
