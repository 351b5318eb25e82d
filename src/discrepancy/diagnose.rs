use std::collections::BTreeMap;
use std::sync::Arc;

use super::averaged::averaged;
use super::cause::Cause;
use super::cross_validation::Folds;
use super::diagnosis::{
    BaselineFit, Diagnosis, Evidence, Finding, Gain, Indistinguishable, LAW_MISFIT, NoiseFound,
    ToleranceFound, Unexplained, Verdict,
};
use super::fit::{Estimate, Fitted, Plain, fit, unguessed};
use super::folds::{Blind, HeldOutTest, moved};
use super::gain_check::GainCheck;
use super::hypothesis::Hypothesis;
use super::limits::{cause_limits, detection_limits};
use super::next_measurement::next_measurement;
use super::progress::Progress;
use super::remainder::{is_at_element_of, predicted, remainder};
use super::sought::{NAMED, Sought, of_place, probability, seek};
use super::stiffness::{CorrectedStiffness, corrected};
use super::structure::{ALL, StructureTest, structure};
use super::subject::{Data, Subject};
use super::unseen::Unseen;
use super::visited::{Found, Visited};
use crate::identify::{IdentifyError, Problem};
use crate::rig::orientation::chi_square_p_value;
use crate::rig::{Measurement, Study};
use crate::tolerance::{Group, Scale};

/// A finding matters when it moves marks by so many of their sigmas,
const MATTERS_MARKS: f64 = 0.2;
/// or the wheel by so many degrees.
const MATTERS_WHEEL_DEG: f64 = 0.01;
/// Structure is there when the hardest of all tests, corrected for their number, has a p-value below this.
const STRUCTURED: f64 = 0.005;
/// Held-out readings less probable than this under the extended model speak against its causes.
const SURPRISED: f64 = 0.002;
/// A cause with which other cases are predicted worse by so many nats is not listed: less is within the error of the comparison.
const WORSE: f64 = 0.5;
/// Rivals are no further behind than so many units of twice the logarithm of probability.
const RIVAL: f64 = 6.0;

/// A diagnosis with the fits behind it.
#[derive(Debug)]
pub struct Outcome<'a> {
    /// The answer.
    pub diagnosis: Diagnosis,
    /// The study under diagnosis.
    pub subject: Subject<'a>,
    /// The model as it was, fitted to all cases.
    pub baseline: Arc<Fitted>,
    /// The extended model, fitted to all cases.
    pub extended: Arc<Fitted>,
    /// The extended model as it is written for others.
    pub plain: Plain,
    /// Tests of structure before and after.
    pub structure: [Vec<StructureTest>; 2],
    /// The cases held out as models predict them that were neither chosen nor fitted with them; `None` without such cases or findings.
    pub unseen: Option<Unseen>,
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
    diagnose_watched(
        problem,
        held_out,
        GainCheck::default(),
        &Progress::default(),
    )
}

/// The same, telling how far it is, with the gain checked as stated.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_watched<'a>(
    problem: &Problem<'a>,
    held_out: Vec<bool>,
    check: GainCheck,
    progress: &Progress,
) -> Result<Outcome<'a>, IdentifyError> {
    let mut subject = Subject::new(problem, held_out);
    subject.watched_by(progress);
    let no_cases = || IdentifyError::NoCases(None);
    let unfitted = subject.clone();
    let mut sought = seek(&mut subject, Data::All, progress).ok_or_else(no_cases)?;
    progress.begin("testing what was found");
    let mut tested = structure(&subject, &sought.leading);
    // The search without the held-out cases says what is gained, and gives this one a second start.
    let is_explained = !unexplained(&tested).structured;
    let is_searched =
        !is_explained || (check != GainCheck::Quick && !sought.leading.chosen.is_empty());
    let mut unseen = is_searched
        .then(|| Unseen::new(&unfitted, progress))
        .flatten();
    if let Some(unseen) = &unseen
        && sought.resume(&subject, unseen.models(), Data::All)
    {
        tested = structure(&subject, &sought.leading);
    }
    let Sought { found, leading } = sought;
    let none = Arc::clone(&found.none);
    let structures = [structure(&subject, &none), tested];
    let blind = Blind::new(&subject, &none).zip(Blind::new(&subject, &leading));
    let tests = blind
        .as_ref()
        .map(|(a, b)| [a.test(&subject, &none), b.test(&subject, &leading)]);
    let (mut findings, order) = findings(&subject, &found, &leading);
    let next = order.iter().find_map(|k| {
        let (instead, what) = rival_fit(&found, &leading, *k)?;
        let own = (&*leading, &leading.chosen[*k]);
        next_measurement(&subject, own, (&instead, &what))
    });
    let mut unexplained = unexplained(&structures[1]);
    let matters = findings.iter().any(|finding| !finding.minor);
    if let (true, Some([_, Some(after)])) = (matters, tests) {
        surprised(&after, &mut unexplained);
    }
    stacked(&findings, &mut unexplained);
    let stand_in = leading.chosen.iter().position(|h| !h.is_named());
    if let Some(at) = stand_in {
        unexplained.structured = true;
        unexplained.places.push(format!(
            "{}, where one force of an unknown law explains more than several causes together",
            leading.chosen[at].address
        ));
    }
    let verdict = if unexplained.structured {
        Verdict::Unexplained
    } else if matters {
        Verdict::Discrepancy
    } else {
        Verdict::Consistent
    };
    if unexplained.structured {
        let before = stand_in.map(|at| without(&found, &leading, at));
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
            unseen = Unseen::refitted_only(&subject, [Arc::clone(&none), Arc::clone(&leading)]);
        }
        let folds = Folds::new(&subject);
        let searched = folds
            .as_ref()
            .filter(|_| check == GainCheck::Folds)
            .and_then(|folds| folds.search(&unfitted, progress));
        cross_validation = searched.or_else(|| folds.as_ref()?.validate(&none, &found.models));
    }
    if let Some(remainder) = &mut unexplained.remainder
        && subject.holds_out()
    {
        let own = unseen.as_ref().and_then(Unseen::own_choice).cloned();
        let own = own.unwrap_or_else(|| Arc::clone(&leading));
        let mut causes = unguessed(&own);
        causes.retain(|(h, _)| h.is_named());
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
    let cut_short = found.cut_short || unseen.as_ref().is_some_and(Unseen::is_cut_short);
    let mut listed = faults_of_marks(&subject);
    listed.append(&mut findings);
    let baseline_rms = match &unseen {
        Some(unseen) => unseen.tests[0].marks_rms,
        None => tests.and_then(|[before, _]| before?.marks_rms),
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
            none_of_these: probability(&found, |causes| !causes.iter().any(Hypothesis::is_named)),
            parameters: averaged(&subject, &found.models),
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
            next_measurement: next,
            interrupted: cut_short,
        },
        structure: structures,
        unseen,
        stiffnesses: corrected(problem, &none, &leading),
        places: found.places,
        cut_short,
        plain: Plain::new(&subject, &leading).ok_or_else(no_cases)?,
        baseline: none,
        extended: leading,
        subject,
    })
}

/// A fitted model with another cause in the place of one.
fn rival_fit(found: &Found, leading: &Fitted, at: usize) -> Option<(Arc<Fitted>, Hypothesis)> {
    found.models.iter().find_map(|(model, _)| {
        let rival = instead(model, leading, at)?;
        Some((Arc::clone(model.fitted.as_ref()?), rival.clone()))
    })
}

/// What a model holds instead of one cause, all others being the same places.
fn instead<'m>(model: &'m Visited, leading: &Fitted, at: usize) -> Option<&'m Hypothesis> {
    let own = &leading.chosen[at];
    let others = Hypothesis::causes(&leading.chosen).filter(|h| !h.same_place(own));
    let mut rest: Vec<&Hypothesis> = Hypothesis::causes(&model.causes).collect();
    if rest.len() != Hypothesis::causes(&leading.chosen).count() {
        return None;
    }
    for other in others {
        let place = rest.iter().position(|h| h.same_place(other))?;
        rest.remove(place);
    }
    rest.pop().filter(|h| !h.same_place(own))
}

/// Findings of the leading model, the most important first; and which of its causes each is.
fn findings(
    subject: &Subject<'_>,
    found: &Found,
    leading: &Arc<Fitted>,
) -> (Vec<Finding>, Vec<usize>) {
    let own = leading.ln_posterior();
    let after = Blind::new(subject, leading);
    let after_test = after
        .as_ref()
        .and_then(|blind| blind.test(subject, leading));
    let folds = Folds::new(subject);
    let of = |k: usize| {
        let h = &leading.chosen[k];
        let mut rivals: Vec<Indistinguishable> = Vec::new();
        for (model, _) in &found.models {
            let Some(rival) = instead(model, leading, k) else {
                continue;
            };
            let behind = 2.0 * (own - model.ln_posterior);
            let known = rivals
                .iter()
                .any(|r| (r.cause, r.address.as_str()) == (rival.cause, rival.address.as_str()));
            if behind <= RIVAL && !known {
                rivals.push(Indistinguishable {
                    cause: rival.cause,
                    address: rival.address.clone(),
                    bic_behind: behind.max(0.0),
                });
            }
        }
        let probability = of_place(found, h);
        let without = without(found, leading, k);
        let evidence = 2.0 * (leading.posterior.ln_z - without.posterior.ln_z);
        let before = Blind::new(subject, &without);
        let before_test = before
            .as_ref()
            .and_then(|blind| blind.test(subject, &without));
        let misfit = if h.is_slab() {
            leading.misfit_without(k, subject.problem.unknowns.len())
        } else {
            // What the others could do without it, tolerances being no larger than they are with it.
            without.at_sizes(&leading.sizes)
        };
        let (marks, wheel) = moved(subject, &leading.misfit, &misfit);
        let advantage = folds
            .as_ref()
            .filter(|_| h.only_case(&subject.rows).is_none())
            .and_then(|folds| folds.advantage(leading, &without));
        let mut numbers = leading.estimates(k);
        let further = leading.chosen.iter().enumerate();
        let mut left = None;
        for (at, other) in further.filter(|(_, other)| other.part > 0 && other.same_place(h)) {
            let own = leading.estimates(at).into_iter();
            if other.is_left_by_law() {
                left = Some(own.map(|n| n.value * n.value).sum::<f64>().sqrt());
                continue;
            }
            numbers.extend(own.map(|n| Estimate {
                name: format!("{}_{}", n.name, other.part + 1),
                ..n
            }));
        }
        let count = numbers.len();
        let finding = Finding {
            cause: h.cause,
            address: h.address.clone(),
            form: (!h.side.is_empty()).then(|| h.side.to_string()),
            members: h.members.clone(),
            probability,
            parameters: numbers
                .iter()
                .map(|n| (n.name.clone(), n.value))
                .chain(left.map(|force| (LAW_MISFIT.to_string(), force)))
                .collect(),
            std_error: numbers
                .iter()
                .map(|n| (n.name.clone(), n.std_error))
                .collect(),
            minor: marks < MATTERS_MARKS && wheel < MATTERS_WHEEL_DEG,
            evidence: Evidence {
                statistic: "evidence",
                value: evidence,
                p_value: (chi_square_p_value(evidence.max(0.0), count) * found.places as f64)
                    .min(1.0),
                bic_gain: evidence + 2.0 * h.ln_prior,
            },
            indistinguishable_from: rivals,
            gain: Gain {
                chi2_per_dof_before: without.posterior.chi_square_per_dof(),
                chi2_per_dof_after: leading.posterior.chi_square_per_dof(),
                held_out_rms_before: before_test.and_then(|test| test.marks_rms),
                held_out_rms_after: after_test.and_then(|test| test.marks_rms),
                held_out_p_value: after_test.map(|test| test.p_value),
                cross_validated_nats: advantage,
            },
        };
        let group = probability
            + finding
                .indistinguishable_from
                .iter()
                .map(|rival| of_rival(found, rival))
                .sum::<f64>();
        (finding, group, k)
    };
    // Beside a force of an unknown law, cases in which it is met badly look like faults of theirs, and what it does beyond the first
    // order looks like a second cause at its own element.
    let stands_in = leading.chosen.iter().find(|h| !h.is_named());
    let of_a_case = |h: &Hypothesis| h.only_case(&subject.rows).is_some();
    let faults = leading.chosen.iter().filter(|h| of_a_case(h)).count();
    let is_told = |k: &usize| {
        let h = &leading.chosen[*k];
        h.part == 0
            && stands_in.is_none_or(|force| {
                h.is_named()
                    && !(faults > 1 && of_a_case(h))
                    && !is_at_element_of(subject.problem.model, h, force)
            })
    };
    let told = (0..leading.chosen.len()).filter(is_told);
    let mut out: Vec<(Finding, f64, usize)> = told.map(of).collect();
    // What makes the prediction of other cases worse is no cause.
    out.retain(|(finding, group, _)| {
        *group > NAMED
            && finding
                .gain
                .cross_validated_nats
                .is_none_or(|nats| nats > -WORSE)
    });
    out.sort_by(|(a, ..), (b, ..)| {
        a.minor
            .cmp(&b.minor)
            .then(b.evidence.value.total_cmp(&a.evidence.value))
    });
    out.into_iter().map(|(finding, _, k)| (finding, k)).unzip()
}

fn of_rival(found: &Found, rival: &Indistinguishable) -> f64 {
    probability(found, |causes| {
        causes
            .iter()
            .any(|h| h.cause == rival.cause && h.address == rival.address)
    })
}

/// The best fitted model without one cause and what refines it; the one without any where there is none.
fn without(found: &Found, leading: &Fitted, at: usize) -> Arc<Fitted> {
    let is_rest = |model: &Visited| {
        let own = &leading.chosen[at];
        let mut rest = leading.chosen.iter().filter(|h| !h.same_place(own));
        model.causes.len() == rest.clone().count()
            && rest.all(|h| model.causes.iter().any(|other| other.same(h)))
    };
    let mut models = found.models.iter().map(|(model, _)| model);
    let fitted = models.find_map(|model| model.fitted.as_ref().filter(|_| is_rest(model)));
    Arc::clone(fitted.unwrap_or(&found.none))
}

/// What the marks alone say: their noise, and readings that are plainly wrong.
fn faults_of_marks(subject: &Subject<'_>) -> Vec<Finding> {
    let mut out = Vec::new();
    let measurement = subject.problem.measurement;
    let fault = |cause, address: String, numbers: [BTreeMap<String, f64>; 2], value: f64| Finding {
        cause,
        address,
        form: None,
        members: Vec::new(),
        probability: 1.0,
        parameters: numbers[0].clone(),
        std_error: numbers[1].clone(),
        minor: true,
        evidence: Evidence {
            statistic: "marks of rigid parts",
            value,
            p_value: chi_square_p_value(value, 1),
            bic_gain: value,
        },
        indistinguishable_from: Vec::new(),
        gain: Gain::default(),
    };
    let noise = &subject.noise;
    if let (true, Some(declared), Some(estimated)) =
        (noise.contradicts(), noise.declared, noise.estimated)
    {
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
    for outlier in &noise.outliers {
        let read = measurement.cases[outlier.case].marks[outlier.reading];
        let part = &measurement.parts[read.part];
        let label = &measurement.cases[outlier.case].label;
        let named = |values: [f64; 3]| {
            let pairs = ["x", "y", "z"].into_iter().zip(values);
            pairs
                .map(|(name, value)| (name.to_string(), value))
                .collect()
        };
        out.push(fault(
            Cause::MarkOutlier,
            format!("case {label} {} {}", part.name, part.marks[read.mark].label),
            [named(outlier.error.into()), named([sigma; 3])],
            outlier.error.norm_squared() / (sigma * sigma),
        ));
    }
    out
}

/// Sizes of tolerances as the report states them.
pub(super) fn tolerances(
    subject: &Subject<'_>,
    fitted: &Fitted,
) -> BTreeMap<String, ToleranceFound> {
    let mut out = BTreeMap::new();
    let sizes = &fitted.sizes;
    let length = subject.millimetre();
    let present = |group: Group| {
        group == Group::Marks && fitted.layout.marks.is_some()
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
            Group::Axes | Group::LoadDirections => (1f64.to_degrees(), "deg"),
            Group::LoadGains | Group::Preloads | Group::SpringRates | Group::KnownStiffnesses => {
                (1.0, "fraction")
            }
            _ => (1.0 / length, "mm"),
        };
        out.insert(
            group.as_str().to_string(),
            ToleranceFound {
                sd: libm::exp(sizes.ln[k]) * scale,
                usual: size.usual * scale,
                unit,
            },
        );
    }
    for (name, scale, factor, unit) in [
        ("pose-noise", Scale::PoseShift, 1.0 / length, "mm"),
        ("pose-noise-turn", Scale::PoseTurn, 1f64.to_degrees(), "deg"),
    ] {
        if let (Some(at), false) = (
            sizes.scale(scale),
            subject.problem.measurement.parts.is_empty(),
        ) {
            let usual = sizes.scales[at - sizes.groups.len()].1.usual;
            out.insert(
                name.to_string(),
                ToleranceFound {
                    sd: libm::exp(sizes.ln[at]) * factor,
                    usual: usual * factor,
                    unit,
                },
            );
        }
    }
    out
}

fn unexplained(after: &[StructureTest]) -> Unexplained {
    let count = after.len() as f64;
    // Whether all readings together agree is one question; where they do not, one of many.
    let corrected = |test: &StructureTest| {
        let asked = if test.what == ALL { 1.0 } else { count };
        (test.p_value * asked).min(1.0)
    };
    let worst = after.iter().map(corrected).fold(1.0, f64::min);
    Unexplained {
        structured: worst < STRUCTURED,
        p_value: worst,
        places: after
            .iter()
            .filter(|test| corrected(test) < STRUCTURED)
            .map(|test| format!("{} (p = {:.1e})", test.what, test.p_value))
            .collect(),
        remainder: None,
    }
}

/// A name that does not predict the cases held out is not to be trusted: what they show beyond it remains unexplained.
fn surprised(test: &HeldOutTest, unexplained: &mut Unexplained) {
    if test.p_value < SURPRISED {
        unexplained.structured = true;
        unexplained.p_value = unexplained.p_value.min(test.p_value);
        unexplained.places.push(format!(
            "the cases held out, which the extended model does not predict to their noise (p = {:.1e})",
            test.p_value
        ));
    }
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
