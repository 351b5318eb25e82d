//! `load-crosstalk`: the rig applies a fraction of one load along another.

use super::super::cause::Cause;
use super::super::hypothesis::Hypothesis;
use super::super::survey::Survey;
use super::load_gain::growing;
use admire_identify::tolerance::EffectGroup;

/// Adds constant and growing cross-talk for every ordered pair of loads.
pub(super) fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    let loads = survey.loads();
    for to in loads {
        for from in loads {
            let address = format!("{}<-{}", to.target, from.target);
            for (member, _) in survey.members(EffectGroup::LoadDirections, &address) {
                out.push(Hypothesis::outstanding(
                    Cause::LoadCrosstalk,
                    address.clone(),
                    "",
                    [(member, "fraction".to_string())],
                    survey.priors().load_crosstalk,
                ));
                let pair = (&to.target, &from.target);
                out.push(growing(
                    survey,
                    Cause::LoadCrosstalk,
                    &address,
                    pair,
                    survey.priors().load_crosstalk,
                ));
            }
        }
    }
}
