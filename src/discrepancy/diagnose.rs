use std::collections::BTreeMap;

use super::cause::Cause;
use super::diagnosis::{
    BaselineFit, Diagnosis, Evidence, Finding, Gain, Indistinguishable, Unexplained, Verdict,
};
use super::extended::{Fitted, fit};
use super::held_out::{held_out_test, moved};
use super::hypothesis::Hypothesis;
use super::screening::penalty;
use super::selection::{Selected, select};
use super::structure::{StructureTest, structure};
use super::subject::{Data, Subject};
use crate::identify::global::Meaning;
use crate::identify::{IdentifyError, Problem};
use crate::rig::orientation::chi_square_p_value;
use crate::rig::{Measurement, Study};

/// A finding matters when it moves held-out marks by so many of their sigmas,
const MATTERS_MARKS: f64 = 0.2;
/// or the wheel by so many degrees.
const MATTERS_WHEEL_DEG: f64 = 0.01;
/// Structure is there when the hardest of all tests, corrected for their number, has a p-value below this.
const STRUCTURED: f64 = 0.005;

/// A diagnosis with the fits behind it.
#[derive(Debug)]
pub struct Outcome<'a> {
    /// The answer.
    pub diagnosis: Diagnosis,
    /// The study under diagnosis.
    pub subject: Subject<'a>,
    /// The model as it was, fitted to all cases.
    pub baseline: Fitted,
    /// The extended model, fitted to all cases.
    pub extended: Fitted,
    /// Tests of structure before and after.
    pub structure: [Vec<StructureTest>; 2],
    /// How many hypotheses were tried.
    pub places: usize,
}

/// The cases no fit sees: those the study names, else every fourth.
pub fn held_out(study: &Study, measurement: &Measurement) -> Vec<bool> {
    match study.hold_out {
        Some(_) => measurement.cases.iter().map(|case| case.held_out).collect(),
        None => (0..measurement.cases.len()).map(|k| k % 4 == 3).collect(),
    }
}

/// Finds what the model of a study gets wrong after its best fit.
///
/// # Errors
/// [`IdentifyError::NoCases`] when the deck cannot be solved where the fit starts.
pub fn diagnose<'a>(
    problem: &Problem<'a>,
    held_out: Vec<bool>,
) -> Result<Outcome<'a>, IdentifyError> {
    let mut subject = Subject::new(problem, held_out);
    let no_cases = || IdentifyError::NoCases(None);
    let any = |_: &Hypothesis| true;
    let seen = fit(&subject, &[], None, Data::Fitted).ok_or_else(no_cases)?;
    let before = held_out_test(&subject, &seen);
    let baseline_dof = seen.dof(&seen.covariance());
    let baseline_fit = BaselineFit {
        chi2_per_dof: seen.chi_square() / baseline_dof,
        held_out_rms: before.and_then(|test| test.marks_rms),
    };
    // The structure is found on the fitted cases, then looked at again with all of them.
    let selected = select(&subject, seen, Data::Fitted, &any, false);
    let again = refit(&subject, &selected.fitted, Data::All).ok_or_else(no_cases)?;
    let mut selected = select(&subject, again, Data::All, &any, true);
    let in_question = significant_offsets(&subject, &selected);
    if !in_question.is_empty() {
        subject.offsets_in_question = in_question;
        if let Some(start) = fit(&subject, &[], None, Data::All) {
            selected = select(&subject, start, Data::All, &any, true);
        }
    }
    let baseline = fit(&subject, &[], None, Data::All).ok_or_else(no_cases)?;
    let findings = findings(&subject, &selected);
    let after = structure(&subject, &selected.fitted);
    let worst = after
        .first()
        .map_or(1.0, |test| test.p_value * after.len() as f64)
        .min(1.0);
    let unexplained = Unexplained {
        structured: worst < STRUCTURED,
        p_value: worst,
        places: after
            .iter()
            .filter(|test| test.p_value * (after.len() as f64) < STRUCTURED)
            .map(|test| format!("{} (p = {:.1e})", test.what, test.p_value))
            .collect(),
    };
    let verdict = if unexplained.structured {
        Verdict::Unexplained
    } else if findings.iter().any(|finding| !finding.minor) {
        Verdict::Discrepancy
    } else {
        Verdict::Consistent
    };
    Ok(Outcome {
        diagnosis: Diagnosis {
            verdict,
            baseline: baseline_fit,
            findings,
            unexplained,
            next_measurement: None,
        },
        structure: [structure(&subject, &baseline), after],
        subject,
        baseline,
        places: selected.places,
        extended: selected.fitted,
    })
}

/// The same model on other data.
fn refit(subject: &Subject<'_>, fitted: &Fitted, data: Data) -> Option<Fitted> {
    let chosen: Vec<_> = fitted
        .chosen
        .iter()
        .map(|h| (h.clone(), vec![0.0; h.numbers.len()]))
        .collect();
    fit(subject, &chosen, Some(fitted), data)
}

/// Bushings whose offset the data demand: Wald's test of its six numbers, penalised as any hypothesis.
fn significant_offsets(subject: &Subject<'_>, selected: &Selected) -> Vec<u32> {
    let fitted = &selected.fitted;
    let covariance = fitted.covariance();
    let catalogue = fitted.prepared.system.catalogue();
    let mut by_bushing: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (k, unknown) in fitted.unknowns.list().iter().enumerate() {
        if let Meaning::Offset(component) = unknown.meaning
            && let Some(id) = catalogue.info(component.stiffness).address.id
        {
            by_bushing.entry(id).or_default().push(k);
        }
    }
    let rows: f64 = fitted.weights.iter().sum();
    by_bushing
        .into_iter()
        .filter(|(_, at)| {
            let block = covariance.select_rows(at).select_columns(at);
            let x =
                nalgebra::DVector::from_iterator(at.len(), at.iter().map(|k| fitted.minimum.x[*k]));
            let Some(factor) = nalgebra::Cholesky::new(block.clone()) else {
                return false;
            };
            let known: f64 = at
                .iter()
                .enumerate()
                .map(|(i, k)| 1.0 - block[(i, i)] / fitted.priors[*k].sd.powi(2))
                .sum();
            let wald = x.dot(&factor.solve(&x));
            wald > penalty(known.max(1.0), rows, selected.places) && !subject.rows.is_empty()
        })
        .map(|(id, _)| id)
        .collect()
}

/// Findings of a selected model with what each gains on held-out cases.
fn findings(subject: &Subject<'_>, selected: &Selected) -> Vec<Finding> {
    let fitted = &selected.fitted;
    let covariance = fitted.covariance();
    // For the gain the same structure is fitted without the cases held out.
    let seen = refit(subject, fitted, Data::Fitted);
    let after = seen.as_ref().and_then(|seen| held_out_test(subject, seen));
    let mut out: Vec<Finding> = Vec::new();
    for (k, hypothesis) in fitted.chosen.iter().enumerate() {
        let rest = |from: &Fitted, data| {
            let mut chosen: Vec<_> = from
                .chosen
                .iter()
                .map(|h| (h.clone(), vec![0.0; h.numbers.len()]))
                .collect();
            chosen.remove(k);
            fit(subject, &chosen, Some(from), data)
        };
        let without = seen.as_ref().and_then(|seen| rest(seen, Data::Fitted));
        let before = without.as_ref().and_then(|w| held_out_test(subject, w));
        let everywhere = hypothesis.cause.of_the_measurement();
        let (marks, wheel) = match (&seen, &without) {
            _ if everywhere => rest(fitted, Data::All)
                .map_or((1.0, 0.0), |without| moved(subject, fitted, &without, true)),
            (Some(with), Some(without)) => moved(subject, with, without, false),
            _ => (1.0, 0.0),
        };
        let gain = selected.gains[k];
        let count = hypothesis.numbers.len();
        let rows: f64 = fitted.weights.iter().sum();
        let dof = fitted.dof(&covariance);
        let estimates = fitted.estimates(k, &covariance);
        let name = |e: &super::extended::Estimate| e.name.clone();
        out.push(Finding {
            cause: hypothesis.cause,
            address: hypothesis.address.clone(),
            parameters: estimates.iter().map(|e| (name(e), e.value)).collect(),
            std_error: estimates.iter().map(|e| (name(e), e.std_error)).collect(),
            minor: marks < MATTERS_MARKS && wheel < MATTERS_WHEEL_DEG,
            evidence: Evidence {
                statistic: "likelihood ratio",
                value: gain,
                p_value: (chi_square_p_value(gain, count) * selected.places as f64).min(1.0),
                bic_gain: gain - penalty(count as f64, rows, selected.places),
            },
            indistinguishable_from: selected.rivals[k]
                .iter()
                .map(|rival| Indistinguishable {
                    cause: rival.cause,
                    address: rival.address.clone(),
                    bic_behind: rival.behind,
                })
                .collect(),
            gain: Gain {
                chi2_per_dof_before: (fitted.chi_square() + gain) / (dof + count as f64),
                chi2_per_dof_after: fitted.chi_square() / dof,
                held_out_rms_before: before.and_then(|test| test.marks_rms),
                held_out_rms_after: after.and_then(|test| test.marks_rms),
                held_out_p_value: after.map(|test| test.p_value),
            },
        });
    }
    // The most important first; faults of single readings after what is wrong with the model.
    out.sort_by(|a, b| {
        let key = |f: &Finding| (f.minor, f.cause == Cause::MarkOutlier);
        key(a)
            .cmp(&key(b))
            .then(b.evidence.value.total_cmp(&a.evidence.value))
    });
    out
}
