//! Benchmark of the identification of hidden effects: `cargo bench --bench discrepancy` prints the tables of the guide over 500 studies.
//!
//! `-- SINGLES CLEAN PAIRS OUTSIDE` sets the numbers of studies of each kind, and `--multilinks N` the maximum number of multilinks among
//! them (20). Seeds start after the seeds of the tests; `--from N` sets another start, and `--tests` runs the studies of the test command.
//! `--show` prints a line per study. `--axle pseudo-mcpherson` or `--axle multilink` selects one axle. `--calm` selects studies without
//! background errors. `--only single` (or `clean`, `pair`, `outside`) selects one kind.

#[path = "../discrepancy/blind/mod.rs"]
mod blind;
#[path = "../common/proportion.rs"]
mod proportion;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use admire_diagnosis::{diagnose, held_out};
use admire_identify::LoadedStudy;
use blind::draw::{CAUSES, Kind, OF_TESTS, Plan, plans};
use blind::judge::line;
use blind::{Axle, Score, Tally, Trial, run};
use proportion::interval95;
use rayon::prelude::*;

/// First seed; the tests use smaller ones.
const FIRST: u64 = 1000;
/// Number of studies of each kind, in the order of the tests: 500 in all, 200 of them clean.
const COUNTS: [usize; 4] = [210, 200, 50, 40];
/// Maximum number of multilink studies.
const MULTILINKS: usize = 20;

fn main() {
    let mut numbers = Vec::new();
    let (mut show, mut first, mut axle, mut tests) = (false, FIRST, None, false);
    let (mut calm, mut only, mut multilinks) = (false, None, MULTILINKS);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--show" => show = true,
            "--tests" => tests = true,
            "--calm" => calm = true,
            "--only" => only = words.next(),
            "--from" => first = words.next().and_then(|n| n.parse().ok()).unwrap_or(FIRST),
            "--axle" => axle = words.next(),
            "--multilinks" => {
                multilinks = words
                    .next()
                    .and_then(|n| n.parse().ok())
                    .unwrap_or(MULTILINKS);
            }
            other => numbers.extend(other.parse::<usize>()),
        }
    }
    if numbers.is_empty() && only.is_none() {
        of_the_corpus();
    }
    let mut chosen: Vec<Plan> = Vec::new();
    for (k, (kind, count, most)) in OF_TESTS.into_iter().enumerate() {
        if tests {
            chosen.extend(plans(kind, 0, count, most));
            continue;
        }
        let count =
            numbers
                .get(k)
                .copied()
                .unwrap_or(if numbers.is_empty() { COUNTS[k] } else { 0 });
        // Two thirds of the multilinks have a single cause, the others none.
        let most = match kind {
            Kind::Single => multilinks - multilinks / 3,
            Kind::Clean => multilinks / 3,
            Kind::Pair | Kind::Outside => 0,
        };
        chosen.extend(plans(kind, first, count, most));
    }
    chosen.retain(|plan| !calm || !plan.background);
    chosen.retain(|plan| {
        only.as_ref()
            .is_none_or(|only| *only == format!("{:?}", plan.kind).to_lowercase())
    });
    chosen.retain(|plan| axle.as_ref().is_none_or(|axle| plan.axle.name() == axle));
    // The longest studies come first, so that none of them runs alone at the end.
    chosen.sort_by_key(|plan| (plan.axle == Axle::McPherson, !plan.background));
    let started = Instant::now();
    let (all, done) = (chosen.len(), AtomicUsize::new(0));
    let trials: Vec<Option<Trial>> = chosen
        .into_par_iter()
        .with_max_len(1)
        .map(|plan| {
            let name = format!("{:?} {} {}", plan.kind, plan.seed, plan.axle.name());
            // A study that fails must not stop the others.
            let trial = catch_unwind(AssertUnwindSafe(|| run(plan)));
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            if count.is_multiple_of(25) {
                let minutes = started.elapsed().as_secs_f64() / 60.0;
                eprintln!("{count} of {all} studies, {minutes:.1} min");
            }
            if let Ok(trial) = trial {
                if show {
                    println!("{}", line(&trial, &blind::judge::score(&trial)));
                }
                Some(trial)
            } else {
                println!("{name} could not be run");
                None
            }
        })
        .collect();
    let tally = Tally::new(trials.into_iter().flatten().collect());
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| word != "--bench")
        .collect();
    let more = if arguments.is_empty() {
        String::new()
    } else {
        format!(" -- {}", arguments.join(" "))
    };
    println!(
        "\n`cargo bench --bench discrepancy{more}`: {} studies in {:.1} min\n",
        tally.trials.len(),
        started.elapsed().as_secs_f64() / 60.0
    );
    rates(&tally);
    by_cause(&tally);
    limit(&tally);
    against_bound(&tally);
    confusion(&tally);
    if !show {
        println!("\nNot right:\n");
        for failure in tally.failures() {
            println!("- {failure}");
        }
    }
}

/// Prints the duration of a full diagnosis of the shipped studies, with no other work running.
fn of_the_corpus() {
    println!("| full diagnosis of | hypotheses | seconds | aim |\n|---|---|---|---|");
    for (name, aim) in [("pseudo-mcpherson", 2), ("multilink", 20)] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("corpus")
            .join(name);
        let started = Instant::now();
        let Some(loaded) = LoadedStudy::read(&folder).value else {
            println!("| {name} | - | - | {aim} |");
            continue;
        };
        let held = held_out(&loaded.study, &loaded.measurement);
        let places = diagnose(&loaded.problem(), held).map_or(0, |outcome| outcome.places);
        let seconds = started.elapsed().as_secs_f64();
        println!("| `corpus/{name}` | {places} | {seconds:.1} | {aim} |");
    }
    println!();
}

fn percent((good, all): (usize, usize)) -> String {
    if all == 0 {
        return "-".to_string();
    }
    let (low, high) = interval95(good, all);
    format!(
        "{:.0} % ({good} of {all}; {:.0} to {:.0} %)",
        100.0 * good as f64 / all as f64,
        100.0 * low,
        100.0 * high
    )
}

fn rates(tally: &Tally) {
    println!("With 95 percent binomial intervals:\n");
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
    row(
        "false alarms: something found in a clean study",
        Kind::Clean,
        |s| !s.cause,
        false,
    );
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

/// Prints the fraction of causes named, by size of the effect; the detection limit is where it exceeds one half.
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
        // Here a diagnosis without findings does not count as an answer.
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

/// Prints the fraction of causes named, by the visible chi-square relative to the detection bound 40 + 2 ln(hypotheses).
fn against_bound(tally: &Tally) {
    println!(
        "| chi-square outside of what a fit can follow, over the bound | studies | something found | cause named | with place |"
    );
    println!("|---|---|---|---|---|");
    let edges = [
        0.0,
        0.25,
        0.5,
        0.75,
        1.0,
        1.5,
        2.0,
        4.0,
        10.0,
        f64::INFINITY,
    ];
    for pair in edges.windows(2) {
        let of = |t: &Trial, _: &Score| {
            let bound = 40.0 + 2.0 * (t.places.max(1) as f64).ln();
            t.plan.kind == Kind::Single && (pair[0]..pair[1]).contains(&(t.planted[0].seen / bound))
        };
        // Here a diagnosis without findings does not count as an answer.
        let spoke = |t: &Trial| t.diagnosis.as_ref().is_some_and(|d| !d.findings.is_empty());
        let (_, all) = tally.count(of, |_| true);
        if all == 0 {
            continue;
        }
        let (_, found) = tally.count(|t, s| of(t, s) && spoke(t), |_| true);
        let (named, _) = tally.count(|t, s| of(t, s) && spoke(t), |s| s.cause);
        let (placed, _) = tally.count(|t, s| of(t, s) && spoke(t), |s| s.address);
        println!(
            "| {} to {} | {all} | {found} | {named} | {placed} |",
            pair[0], pair[1]
        );
    }
    println!();
}

/// Prints planted against named causes, for single causes that can be detected; `consistent` and `unexplained` count as answers.
fn confusion(tally: &Tally) {
    println!(
        "| planted | named (single causes that can be seen; outside causes; nothing) |\n|---|---|"
    );
    let mut rows: BTreeMap<(usize, &str), BTreeMap<String, usize>> = BTreeMap::new();
    for (trial, score) in &tally.trials {
        let kind = trial.plan.kind;
        let planted = trial.planted.first().map_or("nothing", |p| p.plant.cause);
        let skipped = match kind {
            Kind::Single => !score.detectable,
            Kind::Pair => true,
            Kind::Clean | Kind::Outside => false,
        };
        if skipped {
            continue;
        }
        let named = if kind == Kind::Single && score.cause {
            planted.to_string()
        } else if kind == Kind::Outside && !score.confident {
            "no confident name".to_string()
        } else {
            answer(trial)
        };
        let row = rows.entry((kind as usize, planted)).or_default();
        *row.entry(named).or_default() += 1;
    }
    for ((_, planted), named) in rows {
        let words = named.iter().map(|(name, count)| format!("{name} {count}"));
        println!("| {planted} | {} |", words.collect::<Vec<_>>().join(", "));
    }
}

/// Returns the cause of the first finding, or the verdict if there is no finding.
fn answer(trial: &Trial) -> String {
    match &trial.diagnosis {
        None => "none".to_string(),
        Some(d) => match d.findings.first() {
            Some(finding) => finding.cause.as_str().to_string(),
            None => format!("{:?}", d.verdict).to_lowercase(),
        },
    }
}
