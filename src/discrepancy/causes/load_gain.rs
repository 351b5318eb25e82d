//! `load-gain`: the rig's load is wrong by a factor.

use super::super::cause::Cause;
use super::super::hypothesis::Hypothesis;
use super::super::survey::Survey;
use crate::tolerance::Group;

/// A load cell may well be wrong by so much.
const SD: f64 = 0.03;

/// Every load of the study.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    for load in survey.loads() {
        let address = load.target.to_string();
        for (member, _) in survey.members(Group::LoadGains, &address) {
            out.push(Hypothesis::outstanding(
                Cause::LoadGain,
                address.clone(),
                "",
                [(member, "gain".to_string())],
                SD,
            ));
        }
    }
}
