//! Timings of the built-in solver, as JSON on standard output.
//!
//! `cargo bench --bench statics` solves the two axles of the corpus in the load cases of their studies. With a file behind `--` it
//! solves what that says (`tests/bench/peers` writes one): a list of
//! `{ "name", "deck", "loads": ["SFORCE/1"], "cases": [[0.0]], "repeats", "error", "imbalance", "last_part_only" }`.
//! Set-up (reading, compiling, the first rank analysis) is timed apart from the sweeps; each sweep starts at the design position
//! and goes from case to case.

use std::fs;
use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};

use admire::model::Model;
use admire::statics::{Settings, Solver};
use admire::syntax::{Address, Dataset};
use admire::system::{State, System};
use admire::text::Source;

fn main() {
    let job = std::env::args().skip(1).find(|word| !word.starts_with('-'));
    let jobs = match job {
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

/// The two axles of the corpus with the loads of their studies.
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
    let tight = Settings::tight();
    let settings = Settings {
        error: job["error"].as_f64().unwrap_or(tight.error),
        imbalance: job["imbalance"].as_f64().unwrap_or(tight.imbalance),
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
        let (mut iterations, mut poses, mut seconds) = (Vec::new(), Vec::new(), 0.0);
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
            if keep {
                poses.push(shown(&lowered.value, &state, last_only));
            }
        }
        (seconds, iterations, poses, state)
    };
    // The first sweep finds redundant equations; later ones start at the design position knowing them.
    let (first, iterations, poses, end) = sweep(&system.state(), true);
    let mut start = system.state();
    start.redundant = end.redundant;
    let repeats = job["repeats"].as_u64().unwrap_or(9);
    let mut sweeps: Vec<f64> = (0..repeats).map(|_| sweep(&start, false).0).collect();
    sweeps.sort_by(f64::total_cmp);
    json!({
        "name": job["name"],
        "unknowns": system.unknowns(),
        "cases": cases.len(),
        "setup_s": setup,
        "first_sweep_s": first,
        "sweep_s": sweeps.get(sweeps.len() / 2).copied().unwrap_or(first),
        "best_s": sweeps.first().copied().unwrap_or(first),
        "repeats": repeats,
        "iterations": iterations,
        "parts": poses,
    })
}

/// Position of the part frame and its rotation matrix, row by row, of every part or of the last one.
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
