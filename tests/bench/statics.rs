//! Benchmark of the built-in static solver, with JSON on standard output.
//!
//! `cargo bench --bench statics` solves the two axles of the corpus in the load cases of their studies. `-- chains` solves chains of 1,000
//! to 100,000 bodies, whose cost per body and iteration should be constant. `-- FILE` solves the jobs of a file, which `tests/bench/peers`
//! writes: a list of `{ "name", "deck", "loads": ["SFORCE/1"], "cases": [[0.0]], "repeats", "error", "imbalance", "tlimit",
//! "last_part_only" }`.
//!
//! Set-up (reading, compiling, the first rank analysis) is timed separately from the sweeps. Each sweep starts at the design position and
//! proceeds from case to case. `balance_s` is the time of one summation of forces after a solve, and `balance_share` its fraction of a
//! sweep.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};

use admire_solver::model::Model;
use admire_solver::statics::{Balance, Solver, StaticSettings};
use admire_solver::system::{Scratch, State, System};
use admire_syntax::text::Source;
use admire_syntax::{Address, Dataset};

fn main() {
    let job = std::env::args().skip(1).find(|word| !word.starts_with('-'));
    let folder = tempfile::tempdir().expect("a folder for the decks of the chains");
    let jobs = match job {
        Some(word) if word == "chains" => chains(folder.path()),
        Some(path) => {
            let text = fs::read_to_string(&path).expect("a readable job file");
            serde_json::from_str(&text).expect("a job file in JSON")
        }
        None => axles(),
    };
    let results: Vec<Value> = jobs
        .as_array()
        .expect("a list of jobs")
        .iter()
        .map(solve)
        .collect();
    println!("{:#}", Value::from(results));
}

/// Returns the jobs of the two axles of the corpus, with the loads of their studies.
fn axles() -> Value {
    let axle = |name: &str| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("corpus")
            .join(name);
        let table =
            fs::read_to_string(folder.join("load_cases.csv")).expect("load cases of the corpus");
        let cases: Vec<Vec<f64>> = table
            .lines()
            .skip(1)
            .map(|row| {
                let numbers: Vec<f64> = row
                    .split(',')
                    .skip(1)
                    .map(|word| word.trim().parse().expect("a load"))
                    .collect();
                numbers
            })
            .collect();
        json!({
            "name": name,
            "deck": folder.join("reference.adm"),
            "loads": ["SFORCE/3", "SFORCE/2", "SFORCE/1"],
            "cases": cases,
            "repeats": 31,
            "last_part_only": true,
        })
    };
    json!([axle("pseudo-mcpherson"), axle("multilink")])
}

/// Returns jobs of chains of bodies joined by bushings, as in `tests/bench/peers`, bent by gravity and a force at the end.
///
/// Every tenth body is also attached to ground, so that the equations stay well conditioned at any length.
fn chains(folder: &Path) -> Value {
    let jobs: Vec<Value> = [1_000, 10_000, 100_000]
        .into_iter()
        .map(|bodies| {
            let deck = folder.join(format!("chain-{bodies}.adm"));
            fs::write(&deck, chain(bodies)).expect("a writable folder");
            json!({
                "name": format!("chain of {bodies}"),
                "deck": deck,
                "loads": ["SFORCE/1"],
                "cases": [[20.0]],
                "repeats": 5,
                // The round-off of positions times the stiffness grows with the length.
                "imbalance": 1e-6 * f64::from(bodies),
                "error": 1e-4,
                "last_part_only": true,
                "bodies": bodies,
            })
        })
        .collect();
    Value::from(jobs)
}

/// Returns the dataset of a chain of n bodies, each 100 mm long.
fn chain(n: u32) -> String {
    let mut text = String::from(
        "chain\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\nMARKER/2, PART=1, REULER=0D,-90D,0D\nACCGRAV/JGRAV=-9806.65\n",
    );
    for k in 0..n {
        let (id, x) = (k + 2, 100 * k);
        let (cm, i, j) = (10 * id, 10 * id + 1, 10 * id + 2);
        let before = if k == 0 { 1 } else { 10 * (id - 1) + 2 };
        _ = writeln!(
            text,
            "PART/{id}, QG={x},0,0, MASS=1, CM={cm}, IP=100,100,100\nMARKER/{cm}, PART={id}, QP=50,0,0\n\
             MARKER/{i}, PART={id}\nMARKER/{j}, PART={id}, QP=100,0,0\n\
             BUSHING/{id}, I={i}, J={before}, K=1E4,1E4,1E4, KT=1E6,1E6,1E6"
        );
        if k % 10 == 9 {
            let (number, support, x) = (n + id, 10 * id + 3, x + 100);
            _ = writeln!(
                text,
                "MARKER/{support}, PART=1, QP={x},0,0\nBUSHING/{number}, I={j}, J={support}, K=1E4,1E4,1E4, KT=1E6,1E6,1E6"
            );
        }
    }
    _ = writeln!(
        text,
        "SFORCE/1, I={}, J=2, TRANSLATIONAL, ACTIONONLY, FUNCTION=0\nEND",
        10 * (n + 1) + 2
    );
    text
}

fn address(text: &str) -> Address {
    let (kind, id) = text.split_once('/').expect("KIND/id");
    Address {
        kind: kind.to_string(),
        id: Some(id.parse().expect("a number")),
        argument: None,
        index: None,
    }
}

fn solve(job: &Value) -> Value {
    let deck = job["deck"].as_str().expect("the path of a deck");
    let bytes = fs::read(deck).expect("a readable deck");

    let begin = Instant::now();
    let dataset = Dataset::parse(Source::new(deck, bytes)).value;
    let lowered = Model::lower(&dataset);
    assert!(!lowered.has_errors(), "{:?}", lowered.diagnostics);
    let compiled = System::compile(&lowered.value);
    assert!(!compiled.has_errors(), "{:?}", compiled.diagnostics);
    let system = compiled.value;
    let mut solver = Solver::new(&system);
    let mut parameters = system.parameters();
    let tight = StaticSettings::tight();
    let settings = StaticSettings {
        error: job["error"].as_f64().unwrap_or(tight.error),
        imbalance: job["imbalance"].as_f64().unwrap_or(tight.imbalance),
        tlimit: job["tlimit"].as_f64().unwrap_or(tight.tlimit),
        ..tight
    };
    let slots: Vec<_> = job["loads"]
        .as_array()
        .expect("loads")
        .iter()
        .map(|load| {
            let load = address(load.as_str().expect("an address"));
            system.catalogue().slot(&load).expect("a load of the deck")
        })
        .collect();
    let cases: Vec<Vec<f64>> = job["cases"]
        .as_array()
        .expect("cases")
        .iter()
        .map(|case| {
            let values = case.as_array().expect("a list of loads");
            values.iter().map(|v| v.as_f64().expect("a load")).collect()
        })
        .collect();
    let setup = begin.elapsed().as_secs_f64();

    let last_only = job["last_part_only"].as_bool().unwrap_or(false);
    let mut sweep = |start: &State, keep: bool| {
        let mut state = start.clone();
        let (mut iterations, mut factored) = (Vec::new(), 0);
        let (mut poses, mut seconds) = (Vec::new(), 0.0);
        for case in &cases {
            for (slot, value) in slots.iter().zip(case) {
                parameters.set(*slot, *value);
            }
            let begin = Instant::now();
            let report = solver
                .solve(&system, &parameters, &mut state, &settings)
                .unwrap_or_else(|error| panic!("{deck}: {error}"));
            seconds += begin.elapsed().as_secs_f64();
            iterations.push(report.iterations);
            factored += report.factorisations;
            if keep {
                poses.push(shown(&lowered.value, &state, last_only));
            }
        }
        (seconds, (iterations, factored), poses, state)
    };
    // The first sweep finds the redundant equations; later sweeps start at the design position with this result.
    let (first, (iterations, factored), poses, end) = sweep(&system.state(), true);
    let mut start = system.state();
    start.redundant.clone_from(&end.redundant);
    let repeats = job["repeats"].as_u64().unwrap_or(9);
    let mut sweeps: Vec<f64> = (0..repeats).map(|_| sweep(&start, false).0).collect();
    sweeps.sort_by(f64::total_cmp);
    let best = sweeps.first().copied().unwrap_or(first);
    // Every solve ends with a new summation of the forces on all parts.
    let mut scratch = Scratch::new(&system);
    let begin = Instant::now();
    let summed = 20;
    for _ in 0..summed {
        let balance = Balance::of(&system, &parameters, &end, &mut scratch).expect("a balance");
        std::hint::black_box(balance);
    }
    let balance = begin.elapsed().as_secs_f64() / f64::from(summed);
    let total: usize = iterations.iter().sum();
    let per_body = job["bodies"]
        .as_f64()
        .map(|bodies| best * 1e6 / (bodies * total.max(1) as f64));
    json!({
        "us_per_body_and_iteration": per_body,
        "factored": factored,
        "name": job["name"],
        "unknowns": system.unknowns(),
        "cases": cases.len(),
        "setup_s": setup,
        "first_sweep_s": first,
        "sweep_s": sweeps.get(sweeps.len() / 2).copied().unwrap_or(first),
        "best_s": best,
        "balance_s": balance,
        "balance_share": balance * cases.len() as f64 / best,
        "repeats": repeats,
        "iterations": iterations,
        "parts": poses,
    })
}

/// Returns the position of the part frame and its rotation matrix, row by row, for every part or only the last one.
fn shown(model: &Model, state: &State, last_only: bool) -> Value {
    let first = if last_only { model.parts.len() - 1 } else { 0 };
    let parts = model.parts.iter().zip(&state.poses).skip(first);
    parts
        .map(|(part, pose)| {
            let mut numbers: Vec<f64> = pose.p.iter().copied().collect();
            numbers.extend(pose.R.transpose().iter());
            (part.header.id.to_string(), Value::from(numbers))
        })
        .collect::<serde_json::Map<_, _>>()
        .into()
}
