//! Causes hidden by a seed and looked for in the study folder alone. Seeds are counted from zero.

use rayon::prelude::*;

use super::blind::draw::{CAUSES, Kind, plan};
use super::blind::judge::line;
use super::blind::{Axle, Score, Tally, Trial, run};

fn tally(kind: Kind, count: u64) -> Tally {
    let trials = (0..count)
        .into_par_iter()
        .map(|seed| run(plan(kind, seed)))
        .collect();
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

#[test]
fn hidden_causes_are_named() {
    let tally = tally(Kind::Single, 48);
    for cause in CAUSES {
        let seen = |t: &Trial, s: &Score| t.planted[0].plant.cause == cause && s.detectable;
        assert!(
            tally.count(seen, |_| true).1 > 0,
            "{cause} cannot be seen in any"
        );
    }
    let of = |axle: Axle| move |t: &Trial, s: &Score| t.plan.axle == axle && s.detectable;
    holds(
        &tally,
        of(Axle::McPherson),
        |s| s.cause,
        95,
        "McPherson, cause",
    );
    holds(
        &tally,
        of(Axle::McPherson),
        |s| s.address,
        90,
        "McPherson, place",
    );
    holds(
        &tally,
        of(Axle::Multilink),
        |s| s.cause,
        80,
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
        |s| s.address,
        80,
        "too small to be seen",
    );
    holds(
        &tally,
        |_, s| s.detectable && s.held_out_p.is_some(),
        |s| s.held_out_p.is_some_and(|p| p > 0.01),
        95,
        "held-out readings after the extension",
    );
}

#[test]
fn a_clean_study_is_consistent() {
    let tally = tally(Kind::Clean, 12);
    let (quiet, all) = tally.count(|_, _| true, |s| s.cause);
    assert!(all - quiet <= 1, "{} false alarms", all - quiet);
}

#[test]
fn both_causes_of_a_pair_are_named() {
    let tally = tally(Kind::Pair, 8);
    holds(&tally, |_, s| s.detectable, |s| s.cause, 80, "pairs");
}

#[test]
fn a_cause_outside_the_catalogue_gets_no_false_name() {
    let tally = tally(Kind::Outside, 6);
    let (fine, all) = tally.count(|_, _| true, |s| s.cause);
    assert_eq!(fine, all, "{:#?}", tally.failures());
}
