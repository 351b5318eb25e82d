//! Detection limits: the smallest sizes at which errors would be found. With them, the report states which errors the readings cannot
//! reveal.

use std::sync::Arc;

use super::candidate_effect::{
    CandidateEffect, EffectParameter, Parametrisation, Sensitivity, Term,
};
use super::cause::Cause;
use super::diagnosis::{CauseLimit, DetectionLimit};
use super::diagnosis_problem::DiagnosisProblem;
use super::fit::FittedModel;
use super::reduction::{EffectModel, first_member};
use super::remainder::sites_of;
use crate::settings::{MAX_CAUSE_LIMIT_SD, MAX_HARDPOINT_LIMIT_MM};
use admire_identify::tolerance::EffectGroup;

/// Returns, for each hardpoint and axis, the error at which a hardpoint error has a posterior probability of one half. The other hardpoints
/// are assumed to have errors of the size of their tolerance group.
pub fn detection_limits(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
) -> Vec<DetectionLimit> {
    let Some(tau) = fitted.sizes.of(EffectGroup::Hardpoints) else {
        return Vec::new();
    };
    let millimetre = subject.millimetre();
    let slab = subject.problem.priors.hardpoint_mm * millimetre;
    let points = &subject.layer.points;
    // Four candidate effects per hardpoint: all directions together, and each axis alone.
    let odds = subject.problem.priors.class_probability / (4 * points.len()) as f64;
    let mut out = Vec::new();
    for point in points {
        let name = |marker: &admire_solver::model::MarkerIx| {
            format!(
                "MARKER/{}",
                subject.problem.model.markers[marker.0].header.id
            )
        };
        let members: Vec<String> = point.markers.iter().map(name).collect();
        let limit = |member: usize| {
            let d = outstanding(fitted, member, (tau, slab), libm::log(odds))? / millimetre;
            (d < MAX_HARDPOINT_LIMIT_MM).then_some(d)
        };
        let mut mm = [None; 3];
        let mut is_any = false;
        for member in subject.layer.at(EffectGroup::Hardpoints, &members[0]) {
            mm[subject.layer.members[member].axis] = limit(member);
            is_any = true;
        }
        if is_any {
            out.push(DetectionLimit {
                address: members[0].clone(),
                members,
                mm,
            });
        }
    }
    out
}

/// Returns the size `d` at which a freed random effect has a posterior probability of one half. `F` is the information of the readings about
/// the effect, `tau` the standard deviation of its tolerance group, and `slab` the additional standard deviation when freed. With
/// `V0 = 1/F + tau^2` and `V1 = V0 + slab^2`: `d^2 (1/V0 - 1/V1) = ln(V1/V0) - 2 ln(prior odds)`.
fn outstanding(
    fitted: &FittedModel,
    member: usize,
    (tau, slab): (f64, f64),
    ln_odds: f64,
) -> Option<f64> {
    let at = first_member(fitted) + member;
    // A freed random effect has a wider prior; the information of the readings stays the same.
    let prior = fitted.priors[at].prior_sd(&fitted.sizes).powi(2);
    let information = 1.0 / fitted.posterior.covariance[(at, at)] - 1.0 / prior;
    if information <= 1e-6 / prior {
        return None;
    }
    let before = 1.0 / information + tau * tau;
    let after = before + slab * slab;
    let needed = libm::log(after / before) - 2.0 * ln_odds;
    Some((needed / (1.0 / before - 1.0 / after)).sqrt())
}

/// Returns, for each parameter of every other cause, the size `d` at which the cause has a posterior probability of one half in an otherwise
/// correct model. To first order, `d^2 F^2 / (1 + F) = ln(1 + F) - 2 ln(prior odds)`, where `F` is the information of the readings in units
/// of the prior. Among the forms of a cause at one site, the largest limit is reported, because any of the forms may act. Among the first
/// guesses of one law, the smallest limit is reported. Faults of the readings of single cases are left out.
pub fn cause_limits(subject: &DiagnosisProblem<'_>, fitted: &Arc<FittedModel>) -> Vec<CauseLimit> {
    let sites = sites_of(subject, fitted);
    let model = EffectModel::new(subject, fitted, &sites, Vec::new());
    let Some(marginal) = model.marginalised(&fitted.sizes) else {
        return Vec::new();
    };
    let information = model.reduction(&marginal).information_beside_the_fit();
    let mut out: Vec<CauseLimit> = Vec::new();
    for (h, information) in model.effects.iter().zip(&information).skip(model.own) {
        let is_part = h.term > Term::Main || h.joint_with.is_some();
        if h.cause == Cause::HardpointError || is_part || h.only_case(&subject.rows).is_some() {
            continue;
        }
        let mut columns = information.iter();
        for number in &h.numbers {
            let has_column = matches!(number.unknown, Parametrisation::Member(_))
                || number.column != Sensitivity::None;
            let information = has_column.then(|| columns.next()).flatten();
            let d = match number.unknown {
                Parametrisation::Member(member) => {
                    let group = fitted.priors[first_member(fitted) + member].group;
                    let tau = group.and_then(|group| fitted.sizes.of(group));
                    tau.and_then(|tau| outstanding(fitted, member, (tau, number.sd), h.ln_prior))
                        .map(|d| d / number.sd)
                }
                Parametrisation::SlipLength { .. }
                | Parametrisation::Rate { .. }
                | Parametrisation::Offset { .. } => {
                    continue;
                }
                _ => information.and_then(|f| alone(*f, h.ln_prior)),
            };
            let d = d.filter(|d| *d < MAX_CAUSE_LIMIT_SD);
            take(&mut out, h, number, d);
        }
    }
    out
}

/// Returns the size of a parameter, in units of its prior standard deviation, at which its cause has a posterior probability of one half.
/// `information` is in the same units. Returns `None` if the readings are insensitive.
fn alone(information: f64, ln_odds: f64) -> Option<f64> {
    let evidence = libm::log1p(information) - 2.0 * ln_odds;
    (information > 1e-6).then(|| (evidence * (1.0 + information)).sqrt() / information)
}

/// Adds a detection limit to the list, or merges it with the limit of another form of the same cause.
fn take(out: &mut Vec<CauseLimit>, h: &CandidateEffect, number: &EffectParameter, d: Option<f64>) {
    let size = d.map(|d| d * number.sd * number.unit);
    let same = |l: &&mut CauseLimit| {
        (l.cause, l.address.as_str(), l.number.as_str())
            == (h.cause, h.address.as_str(), number.name.as_str())
    };
    if let Some(known) = out.iter_mut().find(same) {
        known.size = if h.cause.has_rough_law() {
            size.into_iter().chain(known.size).reduce(f64::min)
        } else {
            size.zip(known.size).map(|(a, b)| a.max(b))
        };
        return;
    }
    out.push(CauseLimit {
        cause: h.cause,
        address: h.address.clone(),
        number: number.name.clone(),
        size,
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the limit merged from two forms of a cause, in units of its parameter.
    fn joined(cause: Cause, sizes: [Option<f64>; 2]) -> Option<f64> {
        let mut out = Vec::new();
        for size in sizes {
            let number = EffectParameter::new("size", 2.0, Parametrisation::Linear);
            let h = CandidateEffect::plain(cause, "PART/6".to_string(), "", Vec::new());
            take(&mut out, &h, &number, size);
        }
        assert_eq!(out.len(), 1);
        out[0].size
    }

    #[test]
    fn the_limit_is_that_of_the_form_seen_worst_but_for_first_guesses() {
        let link = Cause::LinkCompliance;
        assert_eq!(joined(link, [Some(1.0), Some(3.0)]), Some(6.0));
        assert_eq!(joined(link, [Some(3.0), None]), None);
        let friction = Cause::DryFriction;
        assert_eq!(joined(friction, [Some(1.0), Some(3.0)]), Some(2.0));
        assert_eq!(joined(friction, [None, Some(3.0)]), Some(6.0));
    }
}
