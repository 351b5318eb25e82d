//! Whether an answer is right, now that the truth is open.

use std::path::Path;

use admire_diagnosis::{Diagnosis, Finding, Verdict};
use admire_identify::LoadedStudy;

use super::draw::{Kind, Plan};
use super::trial::{Planted, Trial};

/// Rivals further behind than this are separated by the data.
const SEPARATED: f64 = 6.0;
/// More of them than this is no answer.
const MOST_RIVALS: usize = 3;

/// How an answer is judged.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Score {
    /// Every planted effect is large enough to be seen.
    pub detectable: bool,
    /// Every planted cause is named, or nothing is where nothing can be seen.
    pub cause: bool,
    /// The same with its place.
    pub address: bool,
    /// Something is wrong, says the diagnosis, and it knows what.
    pub confident: bool,
    /// The least p-value of held-out readings after the extension, where something was found.
    pub held_out_p: Option<f64>,
}

/// A small error stands out of what every axle has from so many usual tolerances on.
const STANDS_OUT: f64 = 5.0;

/// True if the effect stands out of the noise (40, and two log-likelihoods for each doubling of the hypotheses) and out of tolerances.
pub fn detectable(planted: &Planted, places: usize) -> bool {
    let tolerances = planted.plant.tolerances(&planted.spec);
    tolerances.is_none_or(|sizes| sizes >= STANDS_OUT)
        && planted.seen >= 40.0 + 2.0 * (places.max(1) as f64).ln()
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
    // With one effect planted, the first finding counts; with several, each has to be among the findings.
    let findings = match trial.planted.len() {
        1 => &diagnosis.findings[..diagnosis.findings.len().min(1)],
        _ => &diagnosis.findings[..],
    };
    let all = |place: bool| {
        let wanted = if seen.is_empty() && !quiet {
            // Something is named although little can be seen: it has to be that.
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

/// Of the planted effects that can be seen: whether any finding names the cause.
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

/// True if a finding names what was planted, first or among few rivals that the data do not separate.
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

/// Where hardpoints and gains carry small errors and nothing else can be seen, those are what is wrong.
fn of_the_background(findings: &[Finding]) -> bool {
    let own = ["hardpoint-error", "assembly-offset", "load-gain"];
    !findings.is_empty() && findings.iter().all(|f| own.contains(&f.cause.as_str()))
}

/// Friction that is stronger one way is dry friction all the same, and a gap in a bushing makes its force rise faster than in
/// proportion: such a name at its place is no false one. So is play of a link that the bushing holds: one after the other they are the
/// same. Creep is known by name.
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

/// True if the finding is at a part that the bushing holds.
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

/// Many trials.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Each trial with its score.
    pub trials: Vec<(Trial, Score)>,
}

impl Tally {
    /// Judges them all.
    pub fn new(trials: Vec<Trial>) -> Self {
        let judged = trials.into_iter().map(|trial| {
            let score = score(&trial);
            (trial, score)
        });
        Self {
            trials: judged.collect(),
        }
    }

    /// How many of the chosen trials are right, and how many were chosen.
    pub fn count(
        &self,
        choose: impl Fn(&Trial, &Score) -> bool,
        right: impl Fn(&Score) -> bool,
    ) -> (usize, usize) {
        let chosen: Vec<_> = self.trials.iter().filter(|(t, s)| choose(t, s)).collect();
        let good = chosen.iter().filter(|(_, score)| right(score)).count();
        (good, chosen.len())
    }

    /// One line per trial that is not right, for those who look into it.
    pub fn failures(&self) -> Vec<String> {
        let wrong = self.trials.iter().filter(|(_, score)| !score.address);
        wrong.map(|(trial, score)| line(trial, score)).collect()
    }
}

/// A trial in one line.
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
