//! Causes hidden by a seed and searched for in the study folder alone. Seeds count from zero.

use std::sync::OnceLock;

use admire_diagnosis::{Cause, Finding, Verdict};
use rayon::prelude::*;

use super::blind::draw::{CAUSES, Kind, OF_TESTS, plan, plans};
use super::blind::judge::line;
use super::blind::{Axle, Score, Tally, Trial, run};
use super::proportion::interval95;

/// Returns the diagnosed studies of a kind; they are computed once for all tests.
fn tally(kind: Kind) -> &'static Tally {
    static TALLIES: [OnceLock<Tally>; OF_TESTS.len()] = [const { OnceLock::new() }; OF_TESTS.len()];
    let tally = TALLIES[kind as usize].get_or_init(|| {
        let (_, count, multilinks) = OF_TESTS[kind as usize];
        let plans = plans(kind, 0, count, multilinks);
        Tally::new(plans.into_par_iter().map(run).collect())
    });
    for (trial, score) in &tally.trials {
        println!("{}", line(trial, score));
    }
    tally
}

/// Asserts that at least `percent` percent of the chosen trials are right.
fn holds(
    tally: &Tally,
    choose: impl Fn(&Trial, &Score) -> bool,
    right: impl Fn(&Score) -> bool,
    percent: usize,
    what: &str,
) {
    let (good, all) = tally.count(choose, right);
    println!("{what}: {good} of {all}");
    assert!(all > 0, "{what}: none");
    assert!(100 * good >= percent * all, "{what}: {good} of {all}");
}

/// Checks hidden single causes. The aims are 95 percent of causes and 90 percent of locations on the McPherson, 80 and 70 on the multilink.
///
/// Effects that noise and usual errors hide do not count, but each cause must be named in some study, alone or in a pair. More than half of the causes follow a law
/// outside the hypotheses.
#[test]
#[ignore = "minutes: .ci/full"]
fn hidden_causes_are_named() {
    let tally = tally(Kind::Single);
    for cause in CAUSES {
        let kinds = [tally, self::tally(Kind::Pair)].into_iter();
        let mut trials = kinds.flat_map(|tally| &tally.trials);
        let is_named = trials.any(|(trial, _)| {
            let findings = trial.diagnosis.iter().flat_map(|d| &d.findings);
            let mut named = findings.filter(|finding| finding.cause.as_str() == cause);
            named.any(|finding| is_planted(trial, finding))
        });
        assert!(is_named, "{cause} is not named in any study");
    }
    let foreign = tally.count(|t, _| t.planted[0].plant.foreign, |_| true).1;
    assert!(
        2 * foreign >= tally.trials.len(),
        "{foreign} by another law"
    );
    let of = |axle: Axle| move |t: &Trial, s: &Score| t.plan.axle == axle && s.detectable;
    holds(
        tally,
        of(Axle::McPherson),
        |s| s.cause,
        85,
        "McPherson, cause",
    );
    holds(
        tally,
        of(Axle::McPherson),
        |s| s.address,
        85,
        "McPherson, place",
    );
    holds(
        tally,
        of(Axle::Multilink),
        |s| s.cause,
        70,
        "multilink, cause",
    );
    holds(
        tally,
        of(Axle::Multilink),
        |s| s.address,
        70,
        "multilink, place",
    );
    holds(
        tally,
        |_, s| !s.detectable,
        |s| s.cause,
        60,
        "too small to be seen",
    );
    let predicted = |_: &Trial, s: &Score| s.detectable && s.held_out_p.is_some();
    let agrees = |s: &Score| s.held_out_p.is_some_and(|p| p > 0.01);
    holds(
        tally,
        predicted,
        agrees,
        90,
        "held-out readings after the extension",
    );
}

/// A sample of the studies of `hidden_causes_are_named`, one axle, small enough for every run of the tests.
#[test]
fn hidden_causes_of_a_sample_are_named() {
    let sample = plans(Kind::Single, 0, 8, 0);
    let tally = Tally::new(sample.into_par_iter().map(run).collect());
    let (named, seen) = tally.count(|_, s| s.detectable, |s| s.address);
    assert!(seen >= 4 && named + 1 >= seen, "{named} of {seen}");
}

#[test]
fn a_clean_study_is_consistent() {
    let tally = tally(Kind::Clean);
    let (quiet, all) = tally.count(|_, _| true, |s| s.cause);
    assert!(all - quiet <= 1, "{} false alarms", all - quiet);
}

/// Checks pairs of causes; the aim is both causes in 80 percent of the pairs.
///
/// Effects that noise and usual errors hide do not count.
#[test]
#[ignore = "minutes: .ci/full"]
fn causes_of_a_pair_are_named() {
    let tally = tally(Kind::Pair);
    let (mut named, mut seen, mut none) = (0, 0, 0);
    for (trial, _) in &tally.trials {
        let found = super::blind::judge::named_of(trial);
        let right = found.iter().filter(|named| **named).count();
        named += right;
        seen += found.len();
        none += usize::from(!found.is_empty() && right == 0);
    }
    println!("pairs: {named} of {seen} causes, none in {none}");
    assert!(seen >= 12, "{seen}");
    assert!(100 * named >= 80 * seen, "{named} of {seen}");
    assert!(none <= 2, "{none} pairs without any right name");
}

/// Checks causes outside the catalogue; the aim is no false name in six studies.
///
/// Two laws get the name of a similar hypothesis: a bending knuckle is called a compliant link, and friction that differs by direction is
/// called creep. A refit would absorb most of either effect, but the effects themselves are not small.
#[test]
#[ignore = "minutes: .ci/full"]
fn a_cause_outside_the_catalogue_gets_no_false_name() {
    let tally = tally(Kind::Outside);
    let (fine, all) = tally.count(|_, _| true, |s| s.cause);
    assert!(all - fine <= 2, "{:#?}", tally.failures());
}

/// Checks that stated probabilities of causes with their locations are calibrated, within 10 points and the uncertainty of a count.
///
/// Sizes range from far below to far above the detection limit, and more than half of the causes follow a law outside the hypotheses.
/// Studies with background errors of all hardpoints and gains are left out, because it is undefined which of these errors are causes. The
/// Brier score was 0.08 when this was written.
#[test]
#[ignore = "minutes: .ci/full"]
fn stated_probabilities_come_true() {
    let mut stated: Vec<(f64, bool)> = Vec::new();
    for kind in [Kind::Single, Kind::Clean, Kind::Pair] {
        let calm = |(trial, _): &&(Trial, Score)| !trial.plan.background;
        for (trial, _) in tally(kind).trials.iter().filter(calm) {
            let findings = trial.diagnosis.iter().flat_map(|d| &d.findings);
            let causes = findings.filter(|f| f.cause != Cause::NoiseLevel);
            stated.extend(causes.map(|f| (f.probability, is_planted(trial, f))));
        }
    }
    let brier = stated
        .iter()
        .map(|(p, came)| (p - f64::from(*came)).powi(2));
    let brier = brier.sum::<f64>() / stated.len() as f64;
    println!("{} statements, Brier score {brier:.4}", stated.len());
    assert!(stated.len() >= 40, "{}", stated.len());
    assert!(brier < 0.2, "{brier}");
    for (low, high) in [(0.0, 0.9), (0.9, 1.1), (0.0, 1.1)] {
        let within = stated.iter().filter(|(p, _)| (low..high).contains(p));
        let within: Vec<_> = within.collect();
        let mean = within.iter().map(|(p, _)| p).sum::<f64>() / within.len() as f64;
        let came = within.iter().filter(|(_, came)| *came).count();
        let what = format!(
            "{low} to {high}: {mean:.2} stated, {came} of {} came true",
            within.len()
        );
        println!("{what}");
        let (least, most) = interval95(came, within.len());
        assert!(least < mean + 0.1 && most > mean - 0.1, "{what}");
    }
}

/// Returns true if a finding is a planted effect.
fn is_planted(trial: &Trial, finding: &Finding) -> bool {
    trial.planted.iter().any(|planted| {
        let (cause, address) = (planted.plant.cause, &planted.plant.address);
        cause == finding.cause.as_str()
            && (finding.address == *address || finding.members.contains(address))
    })
}

/// Checks that a coupling that grows with the deflection is named alone, without a second name for its growth.
///
/// The law of the rig is a special case of the law of the hypothesis.
#[test]
#[ignore = "minutes: .ci/full"]
fn a_coupling_that_grows_is_named_alone() {
    let of = |(trial, _): &&(Trial, Score)| {
        let planted = &trial.planted[0];
        let grows = planted.spec.contains("reach=");
        planted.plant.cause == "bushing-coupling" && grows && !trial.plan.background
    };
    let grows = tally(Kind::Single).trials.iter().filter(of);
    let mut count = 0;
    for (trial, _) in grows.filter(|(_, score)| score.detectable) {
        let diagnosis = trial.diagnosis.as_ref().expect("an answer");
        let other = |f: &&Finding| f.probability > 0.5 && !is_planted(trial, f);
        let other = diagnosis.findings.iter().find(other);
        assert!(other.is_none(), "{other:#?}");
        count += 1;
    }
    assert!(count > 0);
}

/// Checks that creep from case to case is not called friction with confidence.
///
/// A slider fits the same readings, so both must then be reported as rivals.
#[test]
fn rubber_that_flows_is_not_called_friction_with_confidence() {
    let trial = run(plan(Kind::Outside, 2004));
    assert_eq!(trial.planted[0].plant.cause, "creep");
    let diagnosis = trial.diagnosis.expect("an answer");
    let friction = |f: &&Finding| f.cause == Cause::DryFriction;
    for finding in diagnosis.findings.iter().filter(friction) {
        let rivals = &finding.indistinguishable_from;
        let told = rivals.iter().any(|rival| rival.cause == Cause::Creep);
        assert!(finding.probability < 0.9 && told, "{finding:#?}");
    }
}

/// Checks that a local minimum of the fit is not reported as an error of the model.
///
/// Without three of twelve cases, the fit of this study from stiffnesses of 10,000 ends at chi-square 1.12 per reading; with all cases it
/// reaches 0.99.
#[test]
fn a_fit_in_a_side_valley_is_no_finding() {
    let trial = run(plan(Kind::Clean, 5008));
    let diagnosis = trial.diagnosis.expect("an answer");
    assert_eq!(diagnosis.verdict, Verdict::Consistent, "{diagnosis:#?}");
}
