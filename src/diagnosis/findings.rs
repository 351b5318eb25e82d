//! Findings of a search: each cause of the leading (reported) model, with its rivals and its gain.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::candidate_effect::{CandidateEffect, Term};
use super::cause::Cause;
use super::causes::progressive_stiffness::largest_deflection;
use super::cross_validation::Folds;
use super::diagnosis::{Evidence, Finding, Gain, Indistinguishable, LAW_MISFIT};
use super::diagnosis_problem::DiagnosisProblem;
use super::fit::{Estimate, FittedModel};
use super::hold_out_test::{HeldOutTest, HoldOutPrediction, moved};
use super::model_set::Selected;
use super::remainder::is_at_element_of;
use crate::settings::{
    MINOR_MARKS_SIGMA, MINOR_WHEEL_DEG, NAMED_PROBABILITY, RIVAL_WINDOW_TWO_NATS,
};
use admire_study::orientation::chi_square_p_value;

/// Returns a rival of effect `at`: a fitted set in which another cause replaces that effect of the leading set. Also returns the other
/// cause. Returns `None` without such a set.
pub(super) fn rival_fit(
    selected: &Selected,
    at: usize,
) -> Option<(Arc<FittedModel>, CandidateEffect)> {
    let mut rivals = selected.rivals(at);
    rivals.find_map(|(model, rival)| Some((Arc::clone(model.fitted.as_ref()?), rival.clone())))
}

/// Returns the findings of the leading set, the most important first, and the index of each finding among the effects of the set. A cause
/// is a finding if it is more probable than not, alone or together with the causes that cannot be distinguished from it.
///
/// The returned flag is true if some cause acts with a probability above one half, but no cause that matters is a finding.
pub(super) fn findings(
    subject: &DiagnosisProblem<'_>,
    selected: &Selected,
    folds: Option<&Folds<'_>>,
    after: Option<&HeldOutTest>,
) -> (Vec<Finding>, Vec<usize>, bool) {
    let leading = &selected.leading;
    let own = leading.ln_posterior();
    let of = |k: usize| {
        let h = &leading.effects[k];
        let mut rivals: Vec<Indistinguishable> = Vec::new();
        for (model, rival) in selected.rivals(k) {
            let behind = 2.0 * (own - model.ln_posterior);
            let known = rivals
                .iter()
                .any(|r| (r.cause, r.address.as_str()) == (rival.cause, rival.address.as_str()));
            if behind <= RIVAL_WINDOW_TWO_NATS && !known {
                let is_rival = |h: &CandidateEffect| is_at(h, rival.cause, &rival.address);
                rivals.push(Indistinguishable {
                    cause: rival.cause,
                    address: rival.address.clone(),
                    probability: selected.probability(|causes| causes.iter().any(is_rival)),
                    bic_behind: behind.max(0.0),
                });
            }
        }
        let in_group = |other: &CandidateEffect| {
            let mut rivals = rivals.iter();
            other.same_site(h) || rivals.any(|r| is_at(other, r.cause, &r.address))
        };
        let group = selected.probability(|causes| causes.iter().any(in_group));
        let without = without(selected, k);
        let evidence = 2.0 * (leading.posterior.ln_z - without.posterior.ln_z);
        let before = HoldOutPrediction::new(subject, &without);
        // The importance counts the effect of the cause alone. A refit without the cause would absorb part of its effect by wrong values of
        // other parameters.
        let moves = leading
            .effect(subject, k)
            .map(|effect| moved(subject, &effect));
        let advantage = folds
            .filter(|_| h.only_case(&subject.rows).is_none())
            .and_then(|folds| folds.advantage(leading, &without));
        let mut numbers = leading.estimates(k);
        let further = leading.effects.iter().enumerate();
        let mut left = None;
        for (at, other) in
            further.filter(|(_, other)| other.term > Term::Main && other.same_site(h))
        {
            let own = leading.estimates(at).into_iter();
            if other.is_left_by_law() {
                left = Some(own.map(|n| n.value * n.value).sum::<f64>().sqrt());
                continue;
            }
            let named = |name: String| match other.term {
                Term::Further(index) => format!("{name}_{}", index + 1),
                _ => name,
            };
            numbers.extend(own.map(|n| Estimate {
                name: named(n.name),
                ..n
            }));
        }
        let count = numbers.len();
        let finding = Finding {
            cause: h.cause,
            address: h.address.clone(),
            form: (!h.side.is_empty()).then(|| h.side.to_string()),
            members: h.members.clone(),
            probability: selected.of_site(h),
            group_probability: group,
            parameters: numbers
                .iter()
                .map(|n| (n.name.clone(), n.value))
                .chain(left.map(|force| (LAW_MISFIT.to_string(), force)))
                .chain(largest_deflection(h).map(|(name, u)| (name.to_string(), u)))
                .collect(),
            std_error: numbers
                .iter()
                .map(|n| (n.name.clone(), n.std_error))
                .collect(),
            minor: moves
                .is_some_and(|(marks, wheel)| marks < MINOR_MARKS_SIGMA && wheel < MINOR_WHEEL_DEG),
            evidence: Evidence {
                statistic: "evidence",
                value: evidence,
                p_value: (chi_square_p_value(evidence.max(0.0), count) * selected.places as f64)
                    .min(1.0),
                bic_gain: evidence + 2.0 * (leading.ln_prior() - without.ln_prior()),
            },
            indistinguishable_from: rivals,
            gain: Gain {
                chi2_per_dof_before: without.posterior.chi_square_per_dof(),
                chi2_per_dof_after: leading.posterior.chi_square_per_dof(),
                held_out_rms_before: before.and_then(|blind| blind.marks_rms(subject)),
                held_out_rms_after: after.and_then(|test| test.marks_rms),
                held_out_p_value: after.map(|test| test.p_value),
                cross_validated_nats: advantage,
            },
        };
        (finding, k)
    };
    // If the model contains a force of unknown law, cases that this force describes badly look like faults of those cases. Its higher-order
    // effects look like a second cause at the same element.
    let stands_in = leading.effects.iter().find(|h| !h.is_in_catalogue());
    let of_a_case = |h: &CandidateEffect| h.only_case(&subject.rows).is_some();
    let faults = leading.effects.iter().filter(|h| of_a_case(h)).count();
    let is_told = |k: &usize| {
        let h = &leading.effects[*k];
        h.term == Term::Main
            && stands_in.is_none_or(|force| {
                h.is_in_catalogue()
                    && !(faults > 1 && of_a_case(h))
                    && !is_at_element_of(subject.problem.model, h, force)
            })
    };
    let told = (0..leading.effects.len()).filter(is_told);
    let out: Vec<(Finding, usize)> = told.map(of).collect();
    let is_named = |(finding, _): &(Finding, usize)| finding.group_probability > NAMED_PROBABILITY;
    let matters = |(finding, _): &(Finding, usize)| !finding.minor;
    let (mut out, others): (Vec<_>, Vec<_>) = out.into_iter().partition(is_named);
    let is_nameless = selected.none_of_these() < NAMED_PROBABILITY
        && !out.iter().any(matters)
        && others.iter().any(matters);
    out.sort_by(|(a, ..), (b, ..)| {
        a.minor
            .cmp(&b.minor)
            .then(b.evidence.value.total_cmp(&a.evidence.value))
    });
    let (findings, order) = out.into_iter().unzip();
    (findings, order, is_nameless)
}

fn is_at(h: &CandidateEffect, cause: Cause, address: &str) -> bool {
    h.cause == cause && h.address == address
}

/// Returns the fit of the leading set without effect `at` and without further terms of the same law. Falls back to the fit without effects.
pub(super) fn without(selected: &Selected, at: usize) -> Arc<FittedModel> {
    let leading = &selected.leading.effects;
    let is_rest = |fitted: &&Arc<FittedModel>| {
        let mut rest = leading.iter().filter(|h| !h.same_site(&leading[at]));
        fitted.effects.len() == rest.clone().count()
            && rest.all(|h| fitted.effects.iter().any(|other| other.same_form(h)))
    };
    let fitted = selected.fits.iter().find(is_rest);
    Arc::clone(fitted.unwrap_or(&selected.none))
}

/// Returns the findings that the marks alone show: a wrong noise level, misplaced marks and gross errors of readings.
pub(super) fn mark_findings(subject: &DiagnosisProblem<'_>) -> Vec<Finding> {
    let mut out = Vec::new();
    let measurement = subject.problem.measurement;
    let fault = |cause, address: String, numbers: [BTreeMap<String, f64>; 2], value: f64| Finding {
        cause,
        address,
        form: None,
        members: Vec::new(),
        probability: 1.0,
        group_probability: 1.0,
        parameters: numbers[0].clone(),
        std_error: numbers[1].clone(),
        minor: true,
        evidence: Evidence {
            statistic: "marks of rigid parts",
            value,
            p_value: chi_square_p_value(value, numbers[0].len()),
            bic_gain: value,
        },
        indistinguishable_from: Vec::new(),
        gain: Gain::default(),
    };
    let noise = &subject.noise;
    if let (true, Some(declared), Some(estimated)) = (
        subject.declared_noise_rejected(),
        noise.declared,
        noise.estimated,
    ) {
        let one = |value: f64| BTreeMap::from([("sigma".to_string(), value)]);
        let z = libm::log(estimated / declared) / noise.ln_sd;
        out.push(fault(
            Cause::NoiseLevel,
            "marks".to_string(),
            [one(estimated), one(estimated * noise.ln_sd)],
            z * z,
        ));
    }
    let sigma = subject.mark_sigma();
    let named = |values: [f64; 3]| {
        let pairs = ["x", "y", "z"].into_iter().zip(values);
        pairs
            .map(|(name, value)| (name.to_string(), value))
            .collect()
    };
    for misplaced in &noise.misplaced {
        let part = &measurement.parts[misplaced.part];
        let mut found = fault(
            Cause::MarkPlace,
            format!("{} {}", part.name, part.marks[misplaced.mark].label),
            [named(misplaced.error.into()), named([misplaced.sd; 3])],
            misplaced.error.norm_squared() / (misplaced.sd * misplaced.sd),
        );
        let form = if misplaced.is_loose() {
            "loose"
        } else {
            "listed"
        };
        found.form = Some(form.to_string());
        out.push(found);
    }
    for outlier in &noise.outliers {
        let read = measurement.cases[outlier.case].marks[outlier.reading];
        let part = &measurement.parts[read.part];
        let label = &measurement.cases[outlier.case].label;
        out.push(fault(
            Cause::MarkOutlier,
            format!("case {label} {} {}", part.name, part.marks[read.mark].label),
            [named(outlier.error.into()), named([sigma; 3])],
            outlier.error.norm_squared() / (sigma * sigma),
        ));
    }
    out
}
