//! `frame-drift`: the measuring frame moved in a single load case.

use admire_solver::mechanics::Vec3;

use super::super::candidate_effect::{CandidateEffect, EffectParameter, SIX, Sensitivity};
use super::super::cause::Cause;
use super::super::frame::by_frame;
use super::super::operating_points::OperatingPoints;

/// Adds a candidate for every load case with at least four marks: a shift of the measuring frame, and a rotation about the centroid of the
/// marks.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    let measurement = survey.measurement;
    for (case, read) in measurement.cases.iter().enumerate() {
        // Three marks are too few to test a rigid motion, which has six parameters.
        if read.marks.len() < 4 {
            continue;
        }
        let places: Vec<Vec3> = read.marks.iter().map(|mark| mark.x).collect();
        let columns = by_frame(survey.rows(), case, &places, survey.sigma(), 1.0);
        let numbers = columns.into_iter().enumerate().map(|(k, rows)| {
            let sd = if k < 3 {
                survey.priors().frame_shift_mm * survey.millimetre()
            } else {
                survey.priors().frame_turn_deg.to_radians()
            };
            EffectParameter::linear(SIX[k], sd, Sensitivity::Rows(rows))
        });
        out.push(CandidateEffect::plain(
            Cause::FrameDrift,
            format!("case {}", read.label),
            "",
            numbers.collect(),
        ));
    }
}
