//! Causes hidden by a seed and looked for in the study folder alone. Seeds are counted from zero.

use admire::discrepancy::{Cause, Finding, Verdict};
use rayon::prelude::*;

use super::blind::draw::{CAUSES, Kind, OF_TESTS, plan, plans};
use super::blind::judge::line;
use super::blind::{Axle, Score, Tally, Trial, run};

fn tally(kind: Kind) -> Tally {
    let (_, count, multilinks) = OF_TESTS[kind as usize];
    let plans = plans(kind, 0, count, multilinks);
    let trials = plans.into_par_iter().map(run).collect();
    let tally = Tally::new(trials);
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
/// 37 of 41 were right on the McPherson, more than half of them by a law no hypothesis uses; what is held to leaves one or two more for
/// the luck of the noise.
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
        &tally,
        of(Axle::McPherson),
        |s| s.cause,
        86,
        "McPherson, cause",
    );
    holds(
        &tally,
        of(Axle::McPherson),
        |s| s.address,
        86,
        "McPherson, place",
    );
    holds(
        &tally,
        of(Axle::Multilink),
        |s| s.cause,
        70,
        "multilink, cause",
    );
    holds(
        &tally,
        of(Axle::Multilink),
        |s| s.address,
        70,
        "multilink, place",
    );
    holds(
        &tally,
        |_, s| !s.detectable,
        |s| s.cause,
        60,
        "too small to be seen",
    );
    let predicted = |_: &Trial, s: &Score| s.detectable && s.held_out_p.is_some();
    let agrees = |s: &Score| s.held_out_p.is_some_and(|p| p > 0.01);
    holds(
        &tally,
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

/// None of six is the aim, and was reached when this was written; one is left for the luck of the noise.
#[test]
fn a_cause_outside_the_catalogue_gets_no_false_name() {
    let tally = tally(Kind::Outside);
    let (fine, all) = tally.count(|_, _| true, |s| s.cause);
    assert!(all - fine <= 1, "{:#?}", tally.failures());
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
