//! `bushing-orientation`: the bushing is mounted turned about an axis, both sides together, so that nothing is preloaded.

use super::super::cause::Cause;
use super::super::hypothesis::{Hypothesis, SIX};
use super::super::survey::Survey;
use crate::tolerance::Group;

/// Radians a bushing may well be turned.
const SD: f64 = 0.17;

/// Every axis of every bushing.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    for bushing in &survey.model.bushings {
        if !bushing.header.active || !survey.can_turn(bushing.i) || !survey.can_turn(bushing.j) {
            continue;
        }
        let address = format!("BUSHING/{}", bushing.header.id);
        for (axis, (member, _)) in survey
            .members(Group::Axes, &address)
            .into_iter()
            .enumerate()
        {
            out.push(Hypothesis::outstanding(
                Cause::BushingOrientation,
                address.clone(),
                SIX[axis],
                [(member, format!("angle_{}", SIX[axis]))],
                SD,
            ));
        }
    }
}
