//! Judgement of a diagnosis, after the truth is revealed.

use std::path::Path;

use admire_diagnosis::{Diagnosis, Finding, Verdict};
use admire_identify::LoadedStudy;

use super::draw::{Kind, Plan};
use super::trial::{Planted, Trial};

/// Difference in BIC beyond which the data separate rivals.
const SEPARATED: f64 = 6.0;
/// Maximum number of rivals for a finding to count as an answer.
const MOST_RIVALS: usize = 3;

/// Judgement of one diagnosis.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Score {
    /// True if every planted effect is large enough to be detected.
    pub detectable: bool,
    /// True if every detectable cause is named, or nothing is named where nothing is detectable.
    pub cause: bool,
    /// True if the causes are named at their locations.
    pub address: bool,
    /// True if the diagnosis reports a discrepancy with a known cause.
    pub confident: bool,
    /// Smallest p-value of held-out readings after the extension, if there was a finding.
    pub held_out_p: Option<f64>,
}

/// Returns true if the effect stands out from noise and usual errors: its chi-square is above 40 plus 2 ln of the number of hypotheses.
pub fn detectable(planted: &Planted, places: usize) -> bool {
    planted.seen >= 40.0 + 2.0 * (places.max(1) as f64).ln()
}

/// Judges a trial.
pub fn score(trial: &Trial) -> Score {
    let Some(diagnosis) = &trial.diagnosis else {
        return Score {
            detectable: true,
            cause: trial.spoilt,
            address: trial.spoilt,
            confident: false,
            held_out_p: None,
        };
    };
    let seen: Vec<&Planted> = trial
        .planted
        .iter()
        .filter(|planted| detectable(planted, trial.places))
        .collect();
    let confident = diagnosis.verdict == Verdict::Discrepancy;
    let quiet = diagnosis.verdict == Verdict::Consistent;
    // With one planted effect only the first finding counts; with several, each must be among the findings.
    let findings = match trial.planted.len() {
        1 => &diagnosis.findings[..diagnosis.findings.len().min(1)],
        _ => &diagnosis.findings[..],
    };
    let all = |place: bool| {
        let wanted = if seen.is_empty() && !quiet {
            // If something is named although nothing is detectable, it must be what was planted.
            trial.planted.iter().collect()
        } else {
            seen.clone()
        };
        let told = wanted
            .iter()
            .all(|planted| findings.iter().any(|f| names(f, planted, place)));
        told || (seen.is_empty() && trial.plan.background && of_the_background(findings))
    };
    let held_out_p = diagnosis
        .findings
        .iter()
        .filter_map(|finding| finding.gain.held_out_p_value)
        .reduce(f64::min);
    let (cause, address) = match trial.plan.kind {
        Kind::Clean => (quiet, quiet),
        Kind::Single | Kind::Pair => (all(false), all(true)),
        Kind::Outside => {
            let fine = !confident || akin(diagnosis, &trial.plan, &trial.planted[0]);
            (fine, fine)
        }
    };
    Score {
        detectable: seen.len() == trial.planted.len(),
        cause,
        address,
        confident,
        held_out_p,
    }
}

/// Returns for each detectable planted effect whether any finding names its cause.
#[allow(dead_code, reason = "the bench counts whole studies")]
pub fn named_of(trial: &Trial) -> Vec<bool> {
    let Some(diagnosis) = &trial.diagnosis else {
        return vec![false; trial.planted.len()];
    };
    let seen = trial.planted.iter().filter(|p| detectable(p, trial.places));
    seen.map(|planted| {
        let mut findings = diagnosis.findings.iter();
        findings.any(|finding| names(finding, planted, false))
    })
    .collect()
}

/// Returns true if a finding names the planted effect, as its cause or among a few rivals that the data do not separate.
fn names(finding: &Finding, planted: &Planted, place: bool) -> bool {
    let same = |cause: &str, address: &str| {
        cause == planted.plant.cause && (!place || address == planted.plant.address)
    };
    if same(finding.cause.as_str(), &finding.address) {
        return true;
    }
    let rivals = &finding.indistinguishable_from;
    rivals.len() <= MOST_RIVALS
        && rivals.iter().all(|rival| rival.bic_behind <= SEPARATED)
        && rivals
            .iter()
            .any(|rival| same(rival.cause.as_str(), &rival.address))
}

/// Returns true if all findings are background errors of hardpoints and gains, the right answer if nothing else is detectable.
fn of_the_background(findings: &[Finding]) -> bool {
    let own = ["hardpoint-error", "assembly-offset", "load-gain"];
    !findings.is_empty() && findings.iter().all(|f| own.contains(&f.cause.as_str()))
}

/// Returns true if the first finding is a valid name for an effect outside the catalogue.
///
/// Friction that differs by direction may be called dry friction. A gap in a bushing makes its force rise more than proportionally, so it
/// may be called progressive; play of a link held by the bushing is equivalent to it. Creep has a hypothesis under its own name.
fn akin(diagnosis: &Diagnosis, plan: &Plan, planted: &Planted) -> bool {
    let name = match planted.plant.cause {
        "asymmetric-friction" => "dry-friction",
        "free-play" => "progressive-stiffness",
        "creep" => "creep",
        _ => return false,
    };
    let mut first = diagnosis.findings.iter().take(1);
    first.any(|f| {
        (f.cause.as_str() == name && f.address == planted.plant.address)
            || (f.cause.as_str() == planted.plant.cause && is_held(plan, f, planted))
    })
}

/// Returns true if the finding is at a part that the bushing holds.
fn is_held(plan: &Plan, finding: &Finding, planted: &Planted) -> bool {
    let id = |address: &str, kind: &str| {
        let rest = address.strip_prefix(kind)?;
        rest.split('.').next()?.parse::<u32>().ok()
    };
    let (Some(bushing), Some(part)) = (
        id(&planted.plant.address, "BUSHING/"),
        id(&finding.address, "PART/"),
    ) else {
        return false;
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let loaded = LoadedStudy::read(&folder.join(plan.axle.name())).value;
    let loaded = loaded.unwrap();
    let model = loaded.problem().model;
    let mut bushings = model.bushings.iter();
    bushings.any(|b| {
        let sides = [b.i, b.j].map(|marker| model.markers[marker.0].part);
        b.header.id == bushing && sides.iter().any(|s| model.parts[s.0].header.id == part)
    })
}

/// A set of judged trials.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Trials with their scores.
    pub trials: Vec<(Trial, Score)>,
}

impl Tally {
    /// Judges all trials.
    pub fn new(trials: Vec<Trial>) -> Self {
        let judged = trials.into_iter().map(|trial| {
            let score = score(&trial);
            (trial, score)
        });
        Self {
            trials: judged.collect(),
        }
    }

    /// Returns the number of chosen trials that are right, and the number of chosen trials.
    pub fn count(
        &self,
        choose: impl Fn(&Trial, &Score) -> bool,
        right: impl Fn(&Score) -> bool,
    ) -> (usize, usize) {
        let chosen: Vec<_> = self.trials.iter().filter(|(t, s)| choose(t, s)).collect();
        let good = chosen.iter().filter(|(_, score)| right(score)).count();
        (good, chosen.len())
    }

    /// Returns one line for each trial that is not right.
    pub fn failures(&self) -> Vec<String> {
        let wrong = self.trials.iter().filter(|(_, score)| !score.address);
        wrong.map(|(trial, score)| line(trial, score)).collect()
    }
}

/// Formats a trial in one line.
pub fn line(trial: &Trial, score: &Score) -> String {
    let plan = &trial.plan;
    let planted: Vec<String> = trial
        .planted
        .iter()
        .map(|p| {
            format!(
                "{} (rms {:.2} sigma, seen {:.0}{})",
                p.spec,
                p.rms,
                p.seen,
                if p.plant.foreign { ", foreign law" } else { "" }
            )
        })
        .collect();
    let named = trial.diagnosis.as_ref().map_or_else(String::new, |d| {
        let findings: Vec<String> = d
            .findings
            .iter()
            .map(|f| {
                let rivals: Vec<String> = f
                    .indistinguishable_from
                    .iter()
                    .map(|r| format!("{}@{} {:+.1}", r.cause, r.address, r.bic_behind))
                    .collect();
                format!(
                    "{}@{}{}{}",
                    f.cause,
                    f.address,
                    if f.minor { " (minor)" } else { "" },
                    if rivals.is_empty() {
                        String::new()
                    } else {
                        format!(" or {}", rivals.join(" or "))
                    }
                )
            })
            .collect();
        let left = &d.unexplained.places;
        let left = left.first().map_or(String::new(), |l| format!(" [{l}]"));
        format!("{:?}: {}{left}", d.verdict, findings.join("; "))
    });
    format!(
        "{:?} {} {} {:?} sigma {:.4}{}{} | {} | {} | cause {} address {} p {:.2e} {:.1} s",
        plan.kind,
        plan.seed,
        plan.axle.name(),
        plan.programme,
        plan.sigma,
        if plan.background { " background" } else { "" },
        if score.detectable { "" } else { " UNSEEN" },
        planted.join(" + "),
        named,
        if score.cause { "right" } else { "WRONG" },
        if score.address { "right" } else { "WRONG" },
        score.held_out_p.unwrap_or(f64::NAN),
        trial.seconds,
    )
}
