use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::background::Background;
use super::cause::Cause;
use super::diagnosis::{
    BaselineFit, Diagnosis, Evidence, Finding, Gain, Indistinguishable, Unexplained, Verdict,
};
use super::effort::Effort;
use super::extended::{Fitted, Warm, fit};
use super::held_out::{HeldOutTest, held_out_test, marks_gain, moved, worst_case};
use super::hypothesis::{BACKGROUND, Hypothesis, assembly_offset};
use super::next_measurement::next_measurement;
use super::outside::doubted;
use super::screening::penalty;
use super::selection::{Selected, criterion, select};
use super::stiffness::{CorrectedStiffness, corrected};
use super::structure::{StructureTest, structure};
use super::subject::{Data, Subject};
use super::survey::Survey;
use crate::identify::global::Meaning;
use crate::identify::{IdentifyError, Problem};
use crate::rig::orientation::chi_square_p_value;
use crate::rig::{Measurement, Study};

/// A finding matters when it moves held-out marks by so many of their sigmas,
const MATTERS_MARKS: f64 = 0.2;
/// or the wheel by so many degrees.
const MATTERS_WHEEL_DEG: f64 = 0.01;
/// Errors of so many of their usual sizes are small.
const SMALL: f64 = 4.0;
/// Structure is there when the hardest of all tests, corrected for their number, has a p-value below this.
const STRUCTURED: f64 = 0.005;
/// A fit follows its readings when their chi-square has at least this p-value.
const FOLLOWS: f64 = 0.05;
/// Held-out readings less probable than this under the extended model speak against its causes.
const SURPRISED: f64 = 0.05;

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
    /// The cases held out, as the model was and as it is extended, both fitted to the other cases only; `None` without such cases.
    pub held_out: Option<[HeldOutTest; 2]>,
    /// By how much the rms of marks held out falls, and its standard error.
    pub marks_gain: Option<(f64, f64)>,
    /// The model as it was and as it is extended, both fitted without the cases held out.
    pub unseen: Option<[Fitted; 2]>,
    /// Stiffnesses before and after.
    pub stiffnesses: Vec<CorrectedStiffness>,
    /// How many hypotheses were tried.
    pub places: usize,
    /// The search had spent its budget before it came to its end.
    pub cut_short: bool,
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
    let seen = as_it_is(&subject).ok_or_else(no_cases)?;
    let before = held_out_test(&subject, &seen);
    let baseline_dof = seen.dof(&seen.covariance());
    let baseline_fit = BaselineFit {
        chi2_per_dof: seen.chi_square() / baseline_dof,
        held_out_rms: before.and_then(|test| test.marks_rms),
    };
    // The structure is found on the fitted cases, then looked at again with all of them.
    let mut seen = seen;
    let first = (seen.clone(), Vec::new());
    let mut selected = select(&subject, first, Data::Fitted, &any, false);
    if is_background(&subject, &selected) {
        let errors = |data| Arc::new(Background::new(&subject, &seen, data));
        let backgrounds = [errors(Data::Fitted), errors(Data::All)];
        let mut wiser = subject.clone();
        wiser.backgrounds = Some(backgrounds.clone());
        let warm = Some(Warm::at(&seen));
        if let Some(start) = fit(&wiser, &[], warm, Data::Fitted, Effort::FULL) {
            let first = (start.clone(), Vec::new());
            let among = select(&wiser, first, Data::Fitted, &any, false);
            // A few plain errors explain more than many small ones, or less.
            let cost = backgrounds[0].cost(&seen);
            let (plain, with) = (
                criterion(&selected.fitted, selected.places),
                criterion(&among.fitted, among.places) + cost,
            );
            if with < plain {
                selected = among;
                (subject, seen) = (wiser, start);
            }
        }
    }
    let again = refit(&subject, &selected.fitted, Data::All).ok_or_else(no_cases)?;
    let again = (again, selected.gained);
    let selected = select(&subject, again, Data::All, &any, false);
    let in_question = significant_offsets(&subject, &selected);
    let start = if in_question.is_empty() {
        selected.fitted
    } else {
        // The same model, but the offset is no nuisance any more: it has to hold its own against other causes.
        let survey = Survey::new(&subject, &selected.fitted);
        let bushings = subject.problem.model.bushings.iter().enumerate();
        let mut chosen = unguessed(&selected.fitted);
        chosen.extend(
            bushings
                .filter(|(_, bushing)| in_question.contains(&bushing.header.id))
                .map(|(k, _)| assembly_offset(&survey, k))
                .map(|h| (h.clone(), vec![0.0; h.numbers.len()])),
        );
        let warm = Warm::at(&selected.fitted);
        let mut with_question = subject.clone();
        with_question.offsets_in_question = in_question;
        let start = fit(&with_question, &chosen, Some(warm), Data::All, Effort::FULL);
        match start {
            Some(start) => {
                subject = with_question;
                start
            }
            None => selected.fitted,
        }
    };
    let start = (start, selected.gained);
    let selected = select(&subject, start, Data::All, &any, true);
    let cut_short = subject.budget.is_spent();
    let baseline = fit(
        &subject,
        &[],
        Some(Warm::at(&seen)),
        Data::All,
        Effort::FULL,
    )
    .ok_or_else(no_cases)?;
    // For the gain the same structure is fitted without the cases held out.
    let blind = refit(&subject, &selected.fitted, Data::Fitted);
    let (findings, order) = findings(&subject, &selected, blind.as_ref());
    let next = order.iter().find_map(|k| {
        let rival = selected.rivals[*k].first()?;
        let (instead, what) = rival.instead.as_ref()?;
        let own = (&selected.fitted, &selected.fitted.chosen[*k]);
        next_measurement(&subject, own, (instead, what))
    });
    let (after, first) = rayon::join(
        || structure(&subject, &selected.fitted),
        || structure(&subject, &baseline),
    );
    let worst = after
        .first()
        .map_or(1.0, |test| test.p_value * after.len() as f64)
        .min(1.0);
    let mut unexplained = Unexplained {
        structured: worst < STRUCTURED,
        p_value: worst,
        places: after
            .iter()
            .filter(|test| test.p_value * (after.len() as f64) < STRUCTURED)
            .map(|test| format!("{} (p = {:.1e})", test.what, test.p_value))
            .collect(),
    };
    let matters = findings.iter().any(|finding| !finding.minor);
    if let Some(blind) = blind.as_ref().filter(|_| matters) {
        surprised(&subject, blind, &mut unexplained);
    }
    stacked(&findings, &mut unexplained);
    doubted(&subject, &selected, (&findings, &order), &mut unexplained);
    let verdict = if unexplained.structured {
        Verdict::Unexplained
    } else if matters {
        Verdict::Discrepancy
    } else {
        Verdict::Consistent
    };
    // The model as it was, fitted to the same cases and with the same nuisances.
    let unaware = if subject.offsets_in_question.is_empty() {
        Some(seen)
    } else {
        let warm = Warm::at(&baseline);
        fit(&subject, &[], Some(warm), Data::Fitted, Effort::FULL)
    };
    let tests = [unaware.as_ref(), blind.as_ref()]
        .map(|fitted| fitted.and_then(|fitted| held_out_test(&subject, fitted)));
    let unseen = unaware.zip(blind).map(|(before, after)| [before, after]);
    let stiffnesses = corrected(problem, &baseline, &selected.fitted);
    Ok(Outcome {
        diagnosis: Diagnosis {
            verdict,
            baseline: baseline_fit,
            findings,
            unexplained,
            next_measurement: next,
        },
        structure: [first, after],
        held_out: match tests {
            [Some(before), Some(after)] => Some([before, after]),
            _ => None,
        },
        marks_gain: unseen
            .as_ref()
            .and_then(|[before, after]| marks_gain(&subject, before, after)),
        unseen,
        stiffnesses,
        subject,
        baseline,
        places: selected.places,
        cut_short,
        extended: selected.fitted,
    })
}

/// The model as it is, fitted to the cases that are not held out. Where that does not follow the readings the fit may have ended in
/// a side valley, to which all cases together show another way.
fn as_it_is(subject: &Subject<'_>) -> Option<Fitted> {
    let first = fit(subject, &[], None, Data::Fitted, Effort::FULL);
    let follows = |fitted: &Fitted| {
        let dof = fitted.dof(&fitted.covariance()).round() as usize;
        chi_square_p_value(fitted.chi_square(), dof) > FOLLOWS
    };
    if first.as_ref().is_some_and(follows) || !subject.holds_out() {
        return first;
    }
    let all = fit(subject, &[], None, Data::All, Effort::FULL);
    let second = all.and_then(|all| {
        let warm = Some(Warm::at(&all));
        fit(subject, &[], warm, Data::Fitted, Effort::FULL)
    });
    match (first, second) {
        (Some(a), Some(b)) if b.minimum.objective < a.minimum.objective => Some(b),
        (a, b) => a.or(b),
    }
}

/// A name that does not predict the cases held out is not to be trusted: what they show beyond it remains unexplained.
fn surprised(subject: &Subject<'_>, blind: &Fitted, unexplained: &mut Unexplained) {
    let test = held_out_test(subject, blind).filter(|test| test.p_value < SURPRISED);
    let Some(test) = test else { return };
    unexplained.structured = true;
    unexplained.p_value = unexplained.p_value.min(test.p_value);
    let place = worst_case(subject, blind).map_or_else(String::new, |(case, _)| {
        let label = &subject.problem.measurement.cases[case].label;
        format!(", case {label} most")
    });
    unexplained.places.push(format!(
        "the cases held out, which the extended model does not predict to their noise (p = {:.1e}){place}",
        test.p_value
    ));
}

/// Two laws at once in one component: their sum follows the readings, but neither is what that component does.
fn stacked(findings: &[Finding], unexplained: &mut Unexplained) {
    for (k, finding) in findings.iter().enumerate() {
        let of_the_model = |f: &&Finding| !f.minor && !f.cause.of_the_measurement();
        let other = findings[..k]
            .iter()
            .filter(of_the_model)
            .find(|other| other.address == finding.address);
        let Some(other) = other.filter(|_| of_the_model(&finding)) else {
            continue;
        };
        if finding.cause.has_rough_law() || other.cause.has_rough_law() {
            unexplained.structured = true;
            unexplained.places.push(format!(
                "{}, where it takes {} and {} together to follow the readings: its law is another one",
                finding.address, other.cause, finding.cause
            ));
        }
    }
}

/// Whether what was found looks like the small errors that every deck and rig has, several of them at once: then they are part of the
/// noise, and the search begins again.
fn is_background(subject: &Subject<'_>, selected: &Selected) -> bool {
    let fitted = &selected.fitted;
    let covariance = fitted.covariance();
    let (length, gain) = BACKGROUND;
    let length = length * 1e-3 / subject.problem.model.units.length.si;
    let small = (0..fitted.chosen.len()).filter(|k| {
        let numbers = fitted.estimates(*k, &covariance);
        let size = numbers
            .iter()
            .map(|n| n.value * n.value)
            .sum::<f64>()
            .sqrt();
        match fitted.chosen[*k].cause {
            Cause::HardpointError => size < SMALL * length,
            Cause::LoadGain => size < SMALL * gain,
            _ => false,
        }
    });
    small.count() > 1 && fitted.chosen.len() > 2
}

/// The same model on other data.
fn refit(subject: &Subject<'_>, fitted: &Fitted, data: Data) -> Option<Fitted> {
    let chosen = unguessed(fitted);
    fit(subject, &chosen, Some(Warm::at(fitted)), data, Effort::FULL)
}

/// What is in a fit, with guesses that its own values replace.
fn unguessed(fitted: &Fitted) -> Vec<(Hypothesis, Vec<f64>)> {
    let chosen = fitted.chosen.iter();
    chosen
        .map(|h| (h.clone(), vec![0.0; h.numbers.len()]))
        .collect()
}

/// Bushings whose offset the data demand: Wald's test of its six numbers, penalised as any hypothesis.
fn significant_offsets(subject: &Subject<'_>, selected: &Selected) -> Vec<u32> {
    let fitted = &selected.fitted;
    let covariance = fitted.covariance();
    let catalogue = fitted.deck.prepared.system.catalogue();
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

/// Findings of a selected model with what each gains on held-out cases, the most important first; and which of the chosen each is.
fn findings(
    subject: &Subject<'_>,
    selected: &Selected,
    blind: Option<&Fitted>,
) -> (Vec<Finding>, Vec<usize>) {
    let fitted = &selected.fitted;
    let covariance = fitted.covariance();
    let after = blind.and_then(|blind| held_out_test(subject, blind));
    // Several forms of one cause at one place are one finding: two sliders of one contact, two axes of one bushing.
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (k, hypothesis) in fitted.chosen.iter().enumerate() {
        match groups
            .iter_mut()
            .find(|group| fitted.chosen[group[0]].same_place(hypothesis))
        {
            Some(group) => group.push(k),
            None => groups.push(vec![k]),
        }
    }
    let of = |group: &[usize]| {
        let k = group[0];
        let hypothesis = &fitted.chosen[k];
        let rest = |from: &Fitted, data| {
            let mut chosen = unguessed(from);
            for k in group.iter().rev() {
                chosen.remove(*k);
            }
            fit(subject, &chosen, Some(Warm::at(from)), data, Effort::FULL)
        };
        let without = blind.and_then(|blind| rest(blind, Data::Fitted));
        let before = without.as_ref().and_then(|w| held_out_test(subject, w));
        let everywhere = hypothesis.cause.of_the_measurement();
        let without_in_all = (everywhere || group.len() > 1)
            .then(|| rest(fitted, Data::All))
            .flatten();
        let (marks, wheel) = match (blind, &without) {
            _ if everywhere => without_in_all
                .as_ref()
                .map_or((1.0, 0.0), |without| moved(subject, fitted, without, true)),
            (Some(with), Some(without)) => moved(subject, with, without, false),
            _ => (1.0, 0.0),
        };
        let gain = match &without_in_all {
            Some(without) if group.len() > 1 => without.chi_square() - fitted.chi_square(),
            _ => selected.gains[k],
        };
        let rows: f64 = fitted.weights.iter().sum();
        let dof = fitted.dof(&covariance);
        let mut numbers: Vec<(String, f64, f64)> = Vec::new();
        for (nth, k) in group.iter().enumerate() {
            for mut number in fitted.estimates(*k, &covariance) {
                if numbers.iter().any(|(name, ..)| *name == number.name) {
                    number.name = format!("{}_{}", number.name, nth + 1);
                }
                numbers.push((number.name, number.value, number.std_error));
            }
        }
        let count = numbers.len();
        Finding {
            cause: hypothesis.cause,
            address: hypothesis.address.clone(),
            parameters: numbers.iter().map(|n| (n.0.clone(), n.1)).collect(),
            std_error: numbers.iter().map(|n| (n.0.clone(), n.2)).collect(),
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
        }
    };
    let mut out: Vec<(Finding, usize)> = groups
        .par_iter()
        .map(|group| (of(group), group[0]))
        .collect();
    // The most important first.
    out.sort_by(|(a, _), (b, _)| {
        a.minor
            .cmp(&b.minor)
            .then(b.evidence.value.total_cmp(&a.evidence.value))
    });
    out.into_iter().unzip()
}
