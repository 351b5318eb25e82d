use std::collections::BTreeMap;
use std::sync::Arc;

use super::averaged::model_averaged_parameters;
use super::candidate_effect::CandidateEffect;
use super::corrected_number::{CorrectedNumber, corrected};
use super::cross_validation::Folds;
use super::deck_only::DeckOnlyPrediction;
use super::diagnosis::{
    BaselineFit, Diagnosis, Finding, NoiseFound, ToleranceFound, Unexplained, Verdict,
};
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::findings::{findings, mark_findings, rival_fit, without};
use super::fit::{FittedModel, fit, with_zero_guesses};
use super::frame::motions;
use super::gain_check::GainCheck;
use super::hold_out::HoldOutSelection;
use super::hold_out_test::{HeldOutTest, HoldOutPrediction};
use super::lack_of_fit::{is_significant, is_structured, lack_of_fit_tests, least};
use super::limits::{cause_limits, detection_limits};
use super::progress::Progress;
use super::remainder::{predicted, remainder};
use super::selection::Selection;
use crate::settings::{HELD_OUT_LEVEL, HOLD_OUT_PERIOD};
use admire_identify::tolerance::{EffectGroup, NoiseScale};
use admire_identify::{IdentifyError, LackOfFitTest, Problem};
use admire_study::{Measurement, Study};

/// Diagnosis, and the fitted models behind it.
#[derive(Debug)]
pub struct Outcome<'a> {
    /// Diagnosis as written to `diagnosis.json`.
    pub diagnosis: Diagnosis,
    /// Study under diagnosis.
    pub subject: DiagnosisProblem<'a>,
    /// Original model, fitted to all cases.
    pub baseline: Arc<FittedModel>,
    /// Extended model, fitted to all cases.
    pub extended: Arc<FittedModel>,
    /// Prediction of the extended model as exported to a deck, without random effects.
    pub plain: DeckOnlyPrediction,
    /// Tests of structure in the residuals: of the original model, then of the extended model.
    pub structure: [Vec<LackOfFitTest>; 2],
    /// Predictions of the held-out cases by models fitted without these cases. `None` without held-out cases or without findings.
    pub unseen: Option<HoldOutSelection>,
    /// Stiffnesses as estimated by the original and by the extended model.
    pub corrected: Vec<CorrectedNumber>,
    /// Fitted models that contain another cause in place of a finding, in the order of the findings. Some findings have no such model.
    pub rivals: Vec<Rival>,
    /// Number of candidate effects that the search tried.
    pub places: usize,
    /// True if the search ended early: its budget was spent, or the user stopped it.
    pub cut_short: bool,
    /// True if the diagnosis reached its time limit before it was complete.
    pub is_late: bool,
}

impl Outcome<'_> {
    /// Returns true if the user stopped the search. Returns false if the search was completed or spent its budget.
    pub fn is_stopped(&self) -> bool {
        self.subject.progress().is_interrupted()
    }
}

/// Model that explains the readings with another cause in place of one finding.
#[derive(Debug)]
pub struct Rival {
    /// Cause in the finding. The rival model does not contain this cause.
    pub finding: CandidateEffect,
    /// Rival model, fitted to all cases.
    pub fitted: Arc<FittedModel>,
    /// Cause that replaces the finding's cause in the rival model.
    pub instead: CandidateEffect,
}

/// Flags the held-out cases: the cases that the study names, or every fourth case if it names none.
pub fn held_out(study: &Study, measurement: &Measurement) -> Vec<bool> {
    match study.hold_out {
        Some(_) => measurement.cases.iter().map(|case| case.held_out).collect(),
        None => (0..measurement.cases.len())
            .map(|k| k % HOLD_OUT_PERIOD == HOLD_OUT_PERIOD - 1)
            .collect(),
    }
}

/// Finds the causes of the discrepancy between a model and its readings. `held_out` flags the cases that are left out of the fits that
/// measure predictive gain.
///
/// # Errors
/// [`IdentifyError::NoCases`] if the deck has no equilibrium at the start of the fit.
pub fn diagnose<'a>(
    problem: &Problem<'a>,
    held_out: Vec<bool>,
) -> Result<Outcome<'a>, IdentifyError> {
    diagnose_watched(
        problem,
        held_out,
        GainCheck::default(),
        &Progress::default(),
    )
}

/// Runs [`diagnose`] with the given effort for the gain check. `progress` reports the state of the search, and can stop it.
///
/// # Errors
/// The same errors as [`diagnose`].
pub fn diagnose_watched<'a>(
    problem: &Problem<'a>,
    held_out: Vec<bool>,
    check: GainCheck,
    progress: &Progress,
) -> Result<Outcome<'a>, IdentifyError> {
    let no_cases = || IdentifyError::NoCases(None);
    let is_blind = check != GainCheck::Quick;
    let mut unfitted = DiagnosisProblem::with_rig_errors(problem, held_out);
    unfitted.with_progress(progress);
    let selection = Selection::new(unfitted.clone(), is_blind, progress).ok_or_else(no_cases)?;
    let Selection {
        subject,
        selected,
        tested,
        mut unseen,
    } = selection;
    let (none, leading) = (Arc::clone(&selected.none), Arc::clone(&selected.leading));
    let before = if Arc::ptr_eq(&none, &leading) {
        tested.clone()
    } else {
        lack_of_fit_tests(&subject, &none)
    };
    let structures = [before, tested];
    let test =
        |fitted: &FittedModel| HoldOutPrediction::new(&subject, fitted)?.test(&subject, fitted);
    let tests = [test(&none), test(&leading)];
    let folds = Folds::new(&subject);
    let (mut findings, order, is_nameless) =
        findings(&subject, &selected, folds.as_ref(), tests[1].as_ref());
    let rivals = order.iter().filter_map(|k| {
        let (fitted, instead) = rival_fit(&selected, *k)?;
        Some(Rival {
            finding: leading.effects[*k].clone(),
            fitted,
            instead,
        })
    });
    let rivals: Vec<Rival> = rivals.collect();
    let mut unexplained = unexplained(&structures[1]);
    let matters = findings.iter().any(|finding| !finding.minor);
    if let (true, Some(after)) = (matters, &tests[1]) {
        check_posterior_predictive(after, &mut unexplained);
    }
    two_laws_at_one_element(&findings, &mut unexplained);
    if is_nameless {
        unexplained.structured = true;
        let acts = 100.0 * (1.0 - selected.none_of_these());
        unexplained.places.push(format!(
            "an effect that is present with a probability of {acts:.0} %, although no single cause is more probable than not"
        ));
    }
    let stand_in = leading.effects.iter().position(|h| !h.is_in_catalogue());
    if let Some(at) = stand_in {
        unexplained.structured = true;
        unexplained.places.push(format!(
            "{}, where one force of unknown law explains more than several causes together",
            leading.effects[at].address
        ));
    }
    for k in &order {
        let of = |finding: &&Finding| {
            let own = &leading.effects[*k];
            finding.cause == own.cause && finding.address == own.address && !finding.minor
        };
        let Some(finding) = findings.iter().find(of) else {
            continue;
        };
        let rivals = finding.indistinguishable_from.iter();
        let rivals = rivals.map(|rival| (rival.cause, rival.address.as_str()));
        let group: Vec<_> = std::iter::once((finding.cause, finding.address.as_str()))
            .chain(rivals)
            .collect();
        let confirmed = unseen.as_ref().and_then(|unseen| unseen.confirms(&group));
        if confirmed == Some(false) {
            unexplained.structured = true;
            unexplained.places.push(format!(
                "{} at {}, which is probable, but is not found if the held-out cases are left out of the search",
                finding.cause, finding.address
            ));
        }
    }
    let verdict = if unexplained.structured {
        Verdict::Unexplained
    } else if matters {
        Verdict::Discrepancy
    } else {
        Verdict::Consistent
    };
    if unexplained.structured {
        let before = stand_in.map(|at| without(&selected, at));
        unexplained.remainder = remainder(
            &subject,
            before.as_ref().unwrap_or(&leading),
            &leading.sizes,
        );
    }
    let mut cross_validation = None;
    if findings.is_empty() {
        unseen = None;
    } else {
        if unseen.is_none() {
            unseen =
                HoldOutSelection::refit_only(&subject, [Arc::clone(&none), Arc::clone(&leading)]);
        }
        let searched = folds
            .as_ref()
            .filter(|_| check == GainCheck::Folds)
            .and_then(|folds| folds.search(&unfitted, progress));
        let folds = folds.as_ref().filter(|_| !progress.is_stopped());
        cross_validation = searched.or_else(|| folds?.validate(&none, &selected.models));
    }
    if let Some(remainder) = &mut unexplained.remainder
        && subject.holds_out()
    {
        let own = unseen
            .as_ref()
            .and_then(HoldOutSelection::selected_without_held_out)
            .cloned();
        let own = own.unwrap_or_else(|| Arc::clone(&leading));
        let mut causes = with_zero_guesses(&own);
        causes.retain(|(h, _)| h.is_in_catalogue());
        let blind = fit(&subject, &causes, Some((&own, &own.x)), Data::Fitted);
        remainder.held_out = blind.and_then(|blind| {
            let sizes = if stand_in.is_some() {
                &leading.sizes
            } else {
                &blind.sizes
            };
            predicted(&subject, &blind, sizes)
        });
    }
    let cut_short = selected.cut_short
        || progress.is_late()
        || unseen.as_ref().is_some_and(HoldOutSelection::is_cut_short);
    let mut listed = mark_findings(&subject);
    listed.append(&mut findings);
    let baseline_rms = match &unseen {
        Some(unseen) => unseen.tests[0].marks_rms,
        None => tests[0].and_then(|before| before.marks_rms),
    };
    Ok(Outcome {
        diagnosis: Diagnosis {
            verdict,
            solver: None,
            baseline: BaselineFit {
                chi2_per_dof: none.posterior.chi_square_per_dof(),
                held_out_rms: baseline_rms,
            },
            findings: listed,
            none_of_these: selected.none_of_these(),
            parameters: model_averaged_parameters(&subject, &selected.models),
            tolerances: tolerances(&subject, &leading),
            detection_limits: detection_limits(&subject, &leading),
            cause_limits: cause_limits(&subject, &leading),
            noise: NoiseFound {
                declared: subject.noise.declared,
                estimated: subject.noise.estimated,
                dof: subject.tails.map(|tails| tails.nu),
            },
            cross_validation,
            hold_out: unseen.as_ref().and_then(|unseen| unseen.hold_out(&subject)),
            unexplained,
            next_measurement: None,
            interrupted: cut_short,
        },
        rivals,
        structure: structures,
        unseen,
        corrected: corrected(problem, &none, &leading),
        places: selected.places,
        cut_short,
        is_late: progress.is_late(),
        plain: DeckOnlyPrediction::new(&subject, &leading).ok_or_else(no_cases)?,
        baseline: none,
        extended: leading,
        subject,
    })
}

/// Returns the standard deviations of the tolerance groups and of the noise, by name and in the units of the report.
pub(super) fn tolerances(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
) -> BTreeMap<String, ToleranceFound> {
    let mut out = BTreeMap::new();
    let sizes = &fitted.sizes;
    let length = subject.millimetre();
    let present = |group: EffectGroup| {
        group == EffectGroup::Marks && fitted.layout.marks.is_some()
            || matches!(group, EffectGroup::FrameShifts | EffectGroup::FrameTurns)
                && fitted.layout.frames.is_some()
            || motions(subject, &[]).iter().any(|(of, _)| *of == group)
            || subject
                .layer
                .members
                .iter()
                .any(|member| member.group == group)
    };
    for (k, (group, size)) in sizes.groups.iter().enumerate() {
        if !present(*group) {
            continue;
        }
        let (scale, unit) = match group {
            EffectGroup::Axes | EffectGroup::LoadDirections | EffectGroup::FrameTurns => {
                (1f64.to_degrees(), "deg")
            }
            EffectGroup::LoadGains
            | EffectGroup::LoadRepeatability
            | EffectGroup::IdleLoads
            | EffectGroup::Preloads
            | EffectGroup::SpringRates
            | EffectGroup::KnownStiffnesses => (1.0, "fraction"),
            _ => (1.0 / length, "mm"),
        };
        out.insert(
            group.as_str().to_string(),
            ToleranceFound {
                sd: libm::exp(sizes.ln[k]) * scale,
                usual: size.median * scale,
                unit,
                strained: size.is_strained(sizes.ln[k]),
            },
        );
    }
    for (scale, factor, unit) in [
        (NoiseScale::PoseShift, 1.0 / length, "mm"),
        (NoiseScale::PoseTurn, 1f64.to_degrees(), "deg"),
    ] {
        if let (Some(at), false) = (
            sizes.scale(scale),
            subject.problem.measurement.parts.is_empty(),
        ) {
            let size = &sizes.scales[at - sizes.groups.len()].1;
            // A pose error larger than the noise of the marks per coordinate cannot be noise of the marks.
            let coarse =
                scale == NoiseScale::PoseShift && libm::exp(sizes.ln[at]) > subject.mark_sigma();
            out.insert(
                scale.as_str().to_string(),
                ToleranceFound {
                    sd: libm::exp(sizes.ln[at]) * factor,
                    usual: size.median * factor,
                    unit,
                    strained: coarse || size.is_strained(sizes.ln[at]),
                },
            );
        }
    }
    // Noise scales are listed only if they exceed the declared noise by more than their prior allows.
    for (scale, size) in &sizes.scales {
        let name = match scale {
            NoiseScale::PoseShift | NoiseScale::PoseTurn => continue,
            NoiseScale::Marks => "noise of marks".to_string(),
            NoiseScale::WheelPosition => "noise of the wheel position".to_string(),
            NoiseScale::WheelAngles => "noise of the wheel angles".to_string(),
            NoiseScale::Channel(k) => {
                let channels = &subject.problem.measurement.channels;
                format!("noise of {}", channels[*k].name)
            }
        };
        let ln = sizes.scale(*scale).map_or(0.0, |at| sizes.ln[at]);
        if size.is_strained(ln) {
            let found = ToleranceFound {
                sd: libm::exp(ln),
                usual: size.median,
                unit: "times the stated noise",
                strained: true,
            };
            out.insert(name, found);
        }
    }
    out
}

fn unexplained(after: &[LackOfFitTest]) -> Unexplained {
    let worst = least(after);
    let significant = after
        .iter()
        .filter(|test| is_significant(test, after.len()));
    Unexplained {
        structured: is_structured(after),
        p_value: worst,
        places: significant
            .map(|test| format!("{} (p = {:.1e})", test.what, test.p_value))
            .collect(),
        remainder: None,
    }
}

/// Adds the held-out cases to the unexplained structure if the extended model does not predict them to within their noise.
fn check_posterior_predictive(test: &HeldOutTest, unexplained: &mut Unexplained) {
    if test.p_value < HELD_OUT_LEVEL {
        unexplained.structured = true;
        unexplained.p_value = unexplained.p_value.min(test.p_value);
        unexplained.places.push(format!(
            "the cases held out, which the extended model does not predict to within their noise (p = {:.1e})",
            test.p_value
        ));
    }
}

/// Adds a component to the unexplained structure if two findings act in it and at least one of them has an uncertain law. The sum of the two
/// laws follows the readings, but neither is the true law of the component.
fn two_laws_at_one_element(findings: &[Finding], unexplained: &mut Unexplained) {
    for (k, finding) in findings.iter().enumerate() {
        let of_the_model = |f: &&Finding| !f.minor && !f.cause.is_reading_fault();
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
                "{}, where only {} and {} together reproduce the readings: the true force law is a different one",
                finding.address, other.cause, finding.cause
            ));
        }
    }
}
