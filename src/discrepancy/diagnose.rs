use std::collections::BTreeMap;
use std::sync::Arc;

use super::averaged::averaged;
use super::cross_validation::Folds;
use super::diagnosis::{
    BaselineFit, Diagnosis, Finding, NoiseFound, ToleranceFound, Unexplained, Verdict,
};
use super::findings::{faults_of_marks, findings, rival_fit, without};
use super::fit::{Fitted, Plain, fit, unguessed};
use super::folds::{Blind, HeldOutTest};
use super::frame::motions;
use super::gain_check::GainCheck;
use super::hypothesis::Hypothesis;
use super::limits::{cause_limits, detection_limits};
use super::next_measurement::next_measurement;
use super::progress::Progress;
use super::remainder::{predicted, remainder};
use super::rig_errors::{ASKED, RigErrors, SHORT};
use super::search::Search;
use super::sought::{Begun, Sought, as_it_is, probability};
use super::stiffness::{CorrectedStiffness, corrected};
use super::structure::{StructureTest, is_significant, is_structured, least, structure};
use super::subject::{Data, Subject};
use super::unseen::Unseen;
use crate::identify::{IdentifyError, Problem};
use crate::rig::{Measurement, Study};
use crate::tolerance::{Group, Scale};

/// Held-out readings less probable than this under the extended model speak against its causes.
const SURPRISED: f64 = 0.002;

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
    let no_cases = || IdentifyError::NoCases(None);
    let is_blind = check != GainCheck::Quick;
    let mut unfitted = Subject::new(problem, held_out);
    unfitted.watched_by(progress);
    let mut searched = Searched::new(&unfitted, is_blind, progress).ok_or_else(no_cases)?;
    let mut open = vec![
        RigErrors::Loads,
        RigErrors::Frame,
        RigErrors::Alignment,
        RigErrors::Mount,
    ];
    open.retain(|errors| !errors.open(&unfitted).is_empty());
    while let Some(at) = searched.asked(&open) {
        let errors = open.remove(at);
        if let Some((added, again)) = searched.with(errors, &unfitted, is_blind, progress) {
            (unfitted, searched) = (added, again);
        }
    }
    let Searched {
        subject,
        sought,
        tested,
        mut unseen,
    } = searched;
    let Sought { found, leading } = sought;
    let none = Arc::clone(&found.none);
    let structures = [structure(&subject, &none), tested];
    let test = |fitted: &Fitted| Blind::new(&subject, fitted)?.test(&subject, fitted);
    let tests = [test(&none), test(&leading)];
    let folds = Folds::new(&subject);
    let (mut findings, order) = findings(
        &subject,
        &found,
        &leading,
        folds.as_ref(),
        tests[1].as_ref(),
    );
    let next = order.iter().find_map(|k| {
        let (instead, what) = rival_fit(&found, &leading, *k)?;
        let own = (&*leading, &leading.chosen[*k]);
        next_measurement(&subject, own, (&instead, &what))
    });
    let mut unexplained = unexplained(&structures[1]);
    let matters = findings.iter().any(|finding| !finding.minor);
    if let (true, Some(after)) = (matters, &tests[1]) {
        surprised(after, &mut unexplained);
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

/// A search of all cases, and one without those held out.
struct Searched<'a> {
    /// The study, its readings weighed.
    subject: Subject<'a>,
    /// What the search of all cases ended with.
    sought: Sought,
    /// Tests of structure in what its leading model leaves.
    tested: Vec<StructureTest>,
    /// What the other one chose and predicts.
    unseen: Option<Unseen>,
}

impl<'a> Searched<'a> {
    /// `None` where the deck cannot be solved.
    fn new(unfitted: &Subject<'a>, is_blind: bool, progress: &Progress) -> Option<Self> {
        let mut subject = unfitted.clone();
        progress.begin("fitting the model as it is");
        // That without the held-out cases comes first: the fit to all of them begins where it ends, and it owes them nothing.
        let mut begun = Begun::without_held_out(unfitted);
        let known = begun.as_ref().map(|begun| &*begun.none);
        let none = as_it_is(&mut subject, known, Data::All)?;
        progress.begin("searching causes");
        let mut search = Search::new(&subject, Arc::new(none), Data::All);
        // The search without the held-out cases says what is gained. Where a cause acts for sure it comes first: this one begins where it ends.
        let mut unseen = (is_blind && search.is_sure())
            .then(|| Unseen::new(begun.take()?, progress))
            .flatten();
        let is_first = unseen.is_some();
        if is_first {
            progress.renew();
            progress.begin("searching causes");
        }
        // Beside a law that was met badly it would begin with what that law leaves.
        let is_plain = |unseen: &&Unseen| unseen.chosen.chosen.iter().all(Hypothesis::is_plain);
        let start = unseen.as_ref().filter(is_plain);
        let is_second = start.is_none();
        let mut sought = Sought::new(match start {
            Some(start) => search.ended_from(&start.chosen, start.fits()),
            None => search.ended(),
        });
        progress.begin("testing what was found");
        let mut tested = structure(&subject, &sought.leading);
        let is_explained = !unexplained(&tested).structured;
        if !is_first && (!is_explained || (is_blind && !sought.leading.chosen.is_empty())) {
            unseen = begun.and_then(|begun| Unseen::new(begun, progress));
        }
        // Where this search did not begin there, that one gives a second start.
        if is_second
            && let Some(unseen) = &unseen
            && sought.resume(&subject, unseen.models(), Data::All)
        {
            tested = structure(&subject, &sought.leading);
        }
        if unexplained(&tested).structured && sought.with_tails(&mut subject) {
            tested = structure(&subject, &sought.leading);
        }
        Some(Self {
            subject,
            sought,
            tested,
            unseen,
        })
    }

    /// Which errors of the rig the search is to be made again with: those that promise most, if that is enough. A force of an unknown
    /// law may have taken those of loads up.
    fn asked(&self, open: &[RigErrors]) -> Option<usize> {
        let each = open.iter().map(|errors| self.promised(*errors)).enumerate();
        let best = each.max_by(|a, b| a.1.total_cmp(&b.1));
        let best = best.filter(|(_, promised)| *promised >= ASKED);
        let hidden = || open.iter().position(|errors| *errors == RigErrors::Loads);
        match best {
            Some((at, _)) => Some(at),
            None if !self.is_plain() => hidden(),
            None => None,
        }
    }

    /// By how many nats they would make the readings more probable: beside the leading model, or, within twice what is asked, in the place of
    /// one of its causes. Steady ones that the search without the held-out cases does not ask for promise nothing.
    fn promised(&self, errors: RigErrors) -> f64 {
        let (found, leading) = (&self.sought.found, &self.sought.leading);
        let beside = errors.promised(&self.subject, leading);
        if !errors.is_steady() {
            return beside;
        }
        let instead = |at: usize| {
            let rest = without(found, leading, at);
            let own = rest.ln_posterior() - leading.ln_posterior();
            own + errors.promised(&self.subject, &rest) + 2.0 * ASKED
        };
        let most = (0..leading.chosen.len())
            .map(instead)
            .fold(beside, f64::max);
        if self.unseen_agrees(errors) {
            most
        } else {
            0.0
        }
    }

    /// True if the search without the held-out cases asks for them, too, so that those cases do not choose the tolerances that predict them.
    fn unseen_agrees(&self, errors: RigErrors) -> bool {
        let Some(unseen) = &self.unseen else {
            return true;
        };
        let chosen = &unseen.chosen;
        let asks = |fit: &Arc<Fitted>| {
            let behind = chosen.ln_posterior() - fit.ln_posterior();
            let within = if Arc::ptr_eq(fit, chosen) {
                0.0
            } else {
                2.0 * ASKED
            };
            errors.promised(&self.subject, fit) + within >= behind + ASKED
        };
        asks(chosen) || unseen.fits().iter().any(asks)
    }

    /// The same with errors of the rig among the tolerances, where that makes the readings more probable.
    fn with(
        &self,
        errors: RigErrors,
        unfitted: &Subject<'a>,
        is_blind: bool,
        progress: &Progress,
    ) -> Option<(Subject<'a>, Self)> {
        let scattered = unfitted.with_groups(errors.open(unfitted));
        progress.renew();
        if scattered.is_spent() {
            return None;
        }
        // Without a promise beside the leading model they are seldom there: the search of all cases alone tells.
        let is_promised = errors.promised(&self.subject, &self.sought.leading) >= ASKED;
        if !is_promised && !self.gives_way(errors, &Self::of_all_cases(&scattered)?) {
            return None;
        }
        let again = Self::new(&scattered, is_blind, progress)?;
        self.gives_way(errors, &again).then_some((scattered, again))
    }

    /// The search of all cases, nothing else. `None` where the deck cannot be solved.
    fn of_all_cases(unfitted: &Subject<'a>) -> Option<Self> {
        let mut subject = unfitted.clone();
        let none = as_it_is(&mut subject, None, Data::All)?;
        let search = Search::new(&subject, Arc::new(none), Data::All);
        let sought = Sought::new(search.ended());
        Some(Self {
            tested: structure(&subject, &sought.leading),
            subject,
            sought,
            unseen: None,
        })
    }

    /// True if what was found with errors of the rig makes the readings more probable, and would not without them.
    fn gives_way(&self, errors: RigErrors, again: &Self) -> bool {
        let (leading, other) = (&self.sought.leading, &again.sought.leading);
        if errors.carried(&self.subject, other) < ASKED {
            return false;
        }
        if self.subject.tails == again.subject.tails {
            let is_named = leading.chosen.iter().all(Hypothesis::is_named);
            let least = if again.is_plain() && !is_named {
                -SHORT
            } else if other.chosen.len() < leading.chosen.len() {
                0.0
            } else {
                ASKED
            };
            other.ln_posterior() - leading.ln_posterior() > least
        } else {
            // Readings are weighed differently: evidence does not tell.
            again.is_plain()
                && !unexplained(&again.tested).structured
                && other.chosen.len() <= leading.chosen.len()
        }
    }

    /// True if no force of an unknown law is in the leading model.
    fn is_plain(&self) -> bool {
        self.sought.leading.chosen.iter().all(Hypothesis::is_plain)
    }
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
            || matches!(group, Group::FrameShifts | Group::FrameTurns)
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
            Group::Axes | Group::LoadDirections | Group::FrameTurns => (1f64.to_degrees(), "deg"),
            Group::LoadGains
            | Group::LoadRepeatability
            | Group::IdleLoads
            | Group::Preloads
            | Group::SpringRates
            | Group::KnownStiffnesses => (1.0, "fraction"),
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
