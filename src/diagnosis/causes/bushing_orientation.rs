//! `bushing-orientation`: the bushing is mounted with a rotation of both sides together, so that no preload arises.

use super::super::cause::Cause;
use super::super::hypothesis::{Hypothesis, SIX};
use super::super::survey::Survey;
use admire_identify::tolerance::EffectGroup;

/// Adds the rotation of every bushing about each of its axes alone, and about all of them.
pub(super) fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    for bushing in &survey.model.bushings {
        if !bushing.header.active {
            continue;
        }
        let address = format!("BUSHING/{}", bushing.header.id);
        let members = survey.members(EffectGroup::Axes, &address).into_iter();
        let angles: Vec<(usize, String)> = members
            .zip(SIX)
            .map(|((member, _), axis)| (member, format!("angle_{axis}")))
            .collect();
        let mut form = |name, angles: Vec<(usize, String)>| {
            let cause = Cause::BushingOrientation;
            out.push(Hypothesis::outstanding(
                cause,
                address.clone(),
                name,
                angles,
                survey.priors().bushing_orientation_deg.to_radians(),
            ));
        };
        for (angle, axis) in angles.iter().zip(SIX) {
            form(axis, vec![angle.clone()]);
        }
        if angles.len() > 1 {
            form("", angles);
        }
    }
}
