//! How well hidden effects are named: `cargo bench --bench discrepancy -- [singles] [clean]` prints the tables of the README.
//!
//! Seeds start where those of the tests end. `--show` prints a line for every study, `--from N` starts at another seed, `--axle
//! pseudo-mcpherson` or `multilink` leaves the other axle out, `--calm` studies with background errors, `--only single` (or `clean`,
//! `pair`, `outside`) the other kinds; with `--tests` the seeds are those of the tests.

#[path = "../discrepancy/blind/mod.rs"]
mod blind;

use std::collections::BTreeMap;

use blind::draw::{CAUSES, Kind, Plan, plan};
use blind::judge::line;
use blind::{Axle, Score, Tally, Trial, run};
use rayon::prelude::*;

/// Seeds of the tests are smaller.
const FIRST: u64 = 1000;

fn main() {
    let mut numbers = Vec::new();
    let (mut show, mut first, mut axle, mut tests) = (false, FIRST, None, false);
    let (mut calm, mut only) = (false, None);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--show" => show = true,
            "--tests" => tests = true,
            "--calm" => calm = true,
            "--only" => only = words.next(),
            "--from" => first = words.next().and_then(|n| n.parse().ok()).unwrap_or(FIRST),
            "--axle" => axle = words.next(),
            other => numbers.extend(other.parse::<u64>()),
        }
    }
    let singles = numbers.first().copied().unwrap_or(500);
    let clean = numbers.get(1).copied().unwrap_or(singles * 2 / 5);
    let counts = if tests {
        first = 0;
        [48, 12, 8, 6]
    } else {
        [singles, clean, singles / 6, singles / 8]
    };
    let kinds = [Kind::Single, Kind::Clean, Kind::Pair, Kind::Outside];
    let mut plans: Vec<Plan> = Vec::new();
    for (kind, count) in kinds.into_iter().zip(counts) {
        plans.extend((first..first + count).map(|seed| plan(kind, seed)));
    }
    plans.retain(|plan| !calm || !plan.background);
    plans.retain(|plan| {
        only.as_ref()
            .is_none_or(|only| *only == format!("{:?}", plan.kind).to_lowercase())
    });
    plans.retain(|plan| axle.as_ref().is_none_or(|axle| plan.axle.name() == axle));
    let started = std::time::Instant::now();
    let trials: Vec<Trial> = plans
        .into_par_iter()
        .map(|plan| {
            let trial = run(plan);
            if show {
                println!("{}", line(&trial, &blind::judge::score(&trial)));
            }
            trial
        })
        .collect();
    let tally = Tally::new(trials);
    println!(
        "\n{} studies in {:.0} s\n",
        tally.trials.len(),
        started.elapsed().as_secs_f64()
    );
    rates(&tally);
    by_cause(&tally);
    limit(&tally);
    confusion(&tally);
    if !show {
        println!("\nNot right:\n");
        for failure in tally.failures() {
            println!("- {failure}");
        }
    }
}

fn percent((good, all): (usize, usize)) -> String {
    if all == 0 {
        return "-".to_string();
    }
    format!(
        "{:.0} % ({good} of {all})",
        100.0 * good as f64 / all as f64
    )
}

fn rates(tally: &Tally) {
    println!("| | pseudo-mcpherson | multilink |\n|---|---|---|");
    let axles = [Axle::McPherson, Axle::Multilink];
    let row = |name: &str, kind: Kind, right: fn(&Score) -> bool, seen: bool| {
        let cells = axles.map(|axle| {
            let choose = |t: &Trial, s: &Score| {
                t.plan.axle == axle && t.plan.kind == kind && (s.detectable || !seen)
            };
            percent(tally.count(choose, right))
        });
        println!("| {name} | {} | {} |", cells[0], cells[1]);
    };
    let (cause, address): (fn(&Score) -> bool, fn(&Score) -> bool) = (|s| s.cause, |s| s.address);
    row(
        "cause named, where it can be seen",
        Kind::Single,
        cause,
        true,
    );
    row(
        "cause and place named, where they can be seen",
        Kind::Single,
        address,
        true,
    );
    row(
        "right in all, unseen ones included",
        Kind::Single,
        address,
        false,
    );
    row(
        "both causes of a pair, where both can be seen",
        Kind::Pair,
        cause,
        true,
    );
    row("nothing found in a clean study", Kind::Clean, cause, false);
    row(
        "no false name for an outside cause",
        Kind::Outside,
        cause,
        false,
    );
    row(
        "held-out readings agree with the extension, p > 0.01",
        Kind::Single,
        |s| s.held_out_p.is_none_or(|p| p > 0.01),
        true,
    );
    let seconds = axles.map(|axle| {
        let mut times: Vec<f64> = tally
            .trials
            .iter()
            .filter(|(t, _)| t.plan.axle == axle)
            .map(|(t, _)| t.seconds)
            .collect();
        times.sort_by(f64::total_cmp);
        times
            .get(times.len() / 2)
            .map_or_else(|| "-".to_string(), |median| format!("{median:.1} s"))
    });
    println!(
        "| median time of a diagnosis | {} | {} |\n",
        seconds[0], seconds[1]
    );
}

fn by_cause(tally: &Tally) {
    println!(
        "| planted | studies | can be seen | cause named | with place | foreign law | with background |"
    );
    println!("|---|---|---|---|---|---|---|");
    for cause in CAUSES {
        let of = |t: &Trial| t.plan.kind == Kind::Single && t.planted[0].plant.cause == cause;
        let (_, all) = tally.count(|t, _| of(t), |_| true);
        let (_, seen) = tally.count(|t, s| of(t) && s.detectable, |_| true);
        let named = tally.count(|t, s| of(t) && s.detectable, |s| s.cause);
        let placed = tally.count(|t, s| of(t) && s.detectable, |s| s.address);
        let foreign = tally.count(
            |t, s| of(t) && s.detectable && t.planted[0].plant.foreign,
            |s| s.address,
        );
        let background = tally.count(
            |t, s| of(t) && s.detectable && t.plan.background,
            |s| s.address,
        );
        println!(
            "| {cause} | {all} | {seen} | {} | {} | {} | {} |",
            named.0,
            placed.0,
            percent(foreign),
            percent(background)
        );
    }
    println!();
}

/// Share named by size: where it passes a half is the detection limit.
fn limit(tally: &Tally) {
    println!(
        "| rms shift outside of what a fit can follow | studies | something found | cause named | with place |"
    );
    println!("|---|---|---|---|---|");
    let edges = [0.0, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0, f64::INFINITY];
    for pair in edges.windows(2) {
        let of = |t: &Trial| {
            t.plan.kind == Kind::Single && t.planted[0].rms >= pair[0] && t.planted[0].rms < pair[1]
        };
        let chosen: Vec<&(Trial, Score)> = tally.trials.iter().filter(|(t, _)| of(t)).collect();
        if chosen.is_empty() {
            continue;
        }
        let found = chosen
            .iter()
            .filter(|(t, _)| t.diagnosis.as_ref().is_some_and(|d| !d.findings.is_empty()))
            .count();
        // Here silence is no answer.
        let spoke = |t: &Trial| t.diagnosis.as_ref().is_some_and(|d| !d.findings.is_empty());
        let named = chosen.iter().filter(|(t, s)| spoke(t) && s.cause).count();
        let placed = chosen.iter().filter(|(t, s)| spoke(t) && s.address).count();
        println!(
            "| {} to {} sigma | {} | {found} | {named} | {placed} |",
            pair[0],
            pair[1],
            chosen.len()
        );
    }
    println!();
}

/// Planted against named, for single causes that can be seen; `consistent` and `unexplained` are answers too.
fn confusion(tally: &Tally) {
    println!("| planted | named (single causes that can be seen) |\n|---|---|");
    let mut rows: BTreeMap<&str, BTreeMap<String, usize>> = BTreeMap::new();
    for (trial, score) in &tally.trials {
        let (Kind::Single, true, [planted]) =
            (trial.plan.kind, score.detectable, &trial.planted[..])
        else {
            continue;
        };
        let cause = planted.plant.cause;
        let named = if score.cause {
            cause.to_string()
        } else {
            answer(trial)
        };
        *rows.entry(cause).or_default().entry(named).or_default() += 1;
    }
    for (planted, named) in rows {
        let words = named.iter().map(|(name, count)| format!("{name} {count}"));
        println!("| {planted} | {} |", words.collect::<Vec<_>>().join(", "));
    }
}

/// The first name of an answer, or its verdict.
fn answer(trial: &Trial) -> String {
    match &trial.diagnosis {
        None => "none".to_string(),
        Some(d) => match d.findings.first() {
            Some(finding) => finding.cause.as_str().to_string(),
            None => format!("{:?}", d.verdict).to_lowercase(),
        },
    }
}
