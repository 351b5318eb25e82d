//! `load-gain`: a load of the rig is wrong by a factor.

use super::super::candidate_effect::{CandidateEffect, EffectParameter, Sensitivity};
use super::super::cause::Cause;
use super::super::operating_points::OperatingPoints;
use admire_identify::tolerance::EffectGroup;
use admire_syntax::Address;

/// Adds candidates for a constant gain error and a growing gain error of every load.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    for load in survey.loads() {
        let address = load.target.to_string();
        for (member, _) in survey.members(EffectGroup::LoadGains, &address) {
            out.push(CandidateEffect::outstanding(
                Cause::LoadGain,
                address.clone(),
                "",
                [(member, "gain".to_string())],
                survey.priors().load_gain,
            ));
            out.push(growing(
                survey,
                Cause::LoadGain,
                &address,
                &load.target,
                &load.target,
                survey.priors().load_gain,
            ));
        }
    }
}

/// Returns a candidate for an error along the load `to` that grows with the square of the load `from`. Its parameter is the error at the
/// largest load, as a fraction of that load.
pub(super) fn growing(
    survey: &OperatingPoints<'_>,
    cause: Cause,
    address: &str,
    to: &Address,
    from: &Address,
    sd: f64,
) -> CandidateEffect {
    let values = survey.load_values(from);
    let largest = values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let grown = values
        .iter()
        .map(|v| v * v.abs() / largest.max(f64::MIN_POSITIVE));
    let column = Sensitivity::PerCase(vec![(to.clone(), grown.collect())]);
    let numbers = vec![EffectParameter::linear("growth", sd, column)];
    CandidateEffect::plain(cause, address.to_string(), "growing", numbers)
}
