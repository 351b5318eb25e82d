//! `load-crosstalk`: the rig applies a fraction of one load along another load.

use super::super::candidate_effect::CandidateEffect;
use super::super::cause::Cause;
use super::super::operating_points::OperatingPoints;
use super::load_gain::growing;
use admire_identify::tolerance::EffectGroup;

/// Adds candidates for constant and growing cross-talk, for every ordered pair of loads.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    let loads = survey.loads();
    for to in loads {
        for from in loads {
            let address = format!("{}<-{}", to.target, from.target);
            for (member, _) in survey.members(EffectGroup::LoadDirections, &address) {
                out.push(CandidateEffect::outstanding(
                    Cause::LoadCrosstalk,
                    address.clone(),
                    "",
                    [(member, "fraction".to_string())],
                    survey.priors().load_crosstalk,
                ));
                out.push(growing(
                    survey,
                    Cause::LoadCrosstalk,
                    &address,
                    &to.target,
                    &from.target,
                    survey.priors().load_crosstalk,
                ));
            }
        }
    }
}
