//! Results of the shipped and the shared studies, compared with a committed record.
//!
//! The record shows the effect of a change of the inference: verdicts, causes, locations, probabilities, intervals, and the work required.
//! `RECORD=write cargo test --release --test record` rewrites the record. `RECORD=all` compares every study, not only the sample.

#[path = "../common/mod.rs"]
mod common;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use admire::{GainCheck, SharedProgress, Study};
use serde_json::{Map, Value, json};

/// Allowed difference of probabilities.
const PROBABILITY: f64 = 0.02;
/// Allowed difference of values and of interval bounds, relative to the standard error.
const OF_STD_ERROR: f64 = 0.1;
/// Allowed factor between the numbers of sweeps.
const SWEEPS: f64 = 1.5;
/// Studies that take minutes, compared only with `RECORD=all`.
const LONG: [&str; 1] = ["corpus/flexure-finger"];

/// Studies without an entry. The axle of Adams/Car needs a cause that is not in the catalogue yet: curves over the radius of a bushing.
const UNRECORDED: [&str; 1] = ["corpus/adams-car-axle"];

fn record_file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/record/decisions.json")
}

/// Returns every measured study by its name in the record, and the shared studies if available. A study with only a target has no load cases.
fn studies() -> BTreeMap<String, PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = BTreeMap::new();
    let shared = common::shared("reference/realistic-axles");
    let folders = [("corpus", Some(root.join("corpus"))), ("shared", shared)];
    for (name, folder) in folders {
        let Some(folder) = folder else { continue };
        for entry in std::fs::read_dir(folder).expect("readable folder") {
            let study = entry.expect("readable entry").path();
            let text = std::fs::read_to_string(study.join("study.toml")).unwrap_or_default();
            if text.contains("[loads]") {
                let last = study.file_name().expect("a folder has a name");
                let name = format!("{name}/{}", last.display());
                if !UNRECORDED.contains(&name.as_str()) {
                    found.insert(name, study.clone());
                }
            }
        }
    }
    found
}

/// Shared studies that every run of the tests compares, in addition to the shipped ones.
const SAMPLE: [&str; 5] = [
    "shared/clean-0",
    "shared/hardpoint-friction-0",
    "shared/outliers-0",
    "shared/pose-noise-0",
    "shared/tolerances-progressive-0",
];

/// Returns true for studies that every run of the tests compares.
fn is_in_sample(name: &str) -> bool {
    SAMPLE.contains(&name) || (name.starts_with("corpus/") && !LONG.contains(&name))
}

/// Rounds to four significant digits, the precision of the record.
fn rounded(number: f64) -> Value {
    let text = format!("{number:.3e}");
    json!(text.parse::<f64>().expect("a number that was printed"))
}

/// Returns the listed members of an object, with rounded numbers.
fn picked(object: &Value, keys: &[&str]) -> Map<String, Value> {
    let mut found = Map::new();
    for key in keys {
        let value = match &object[*key] {
            Value::Null => continue,
            Value::Number(number) if number.is_f64() => rounded(number.as_f64().expect("a float")),
            Value::Array(values) => values
                .iter()
                .map(|value| value.as_f64().map_or_else(|| value.clone(), rounded))
                .collect(),
            Value::Object(numbers) => numbers
                .iter()
                .map(|(key, value)| {
                    let value = value.as_f64().map_or_else(|| value.clone(), rounded);
                    (key.clone(), value)
                })
                .collect(),
            other => other.clone(),
        };
        found.insert((*key).to_string(), value);
    }
    found
}

fn list(object: &Value) -> &[Value] {
    object.as_array().map_or(&[], Vec::as_slice)
}

fn parameters(answer: &Value) -> Map<String, Value> {
    list(&answer["parameters"])
        .iter()
        .map(|parameter| {
            let address = parameter["address"].as_str().expect("an address");
            let what = picked(parameter, &["value", "std_error", "interval95", "status"]);
            (address.to_string(), Value::Object(what))
        })
        .collect()
}

/// Returns the recorded part of `diagnosis.json`.
fn diagnosed(answer: &Value, sweeps: usize) -> Value {
    let findings: Vec<Value> = list(&answer["findings"])
        .iter()
        .map(|finding| {
            let mut what = picked(
                finding,
                &[
                    "cause",
                    "address",
                    "form",
                    "members",
                    "probability",
                    "group_probability",
                    "minor",
                    "parameters",
                    "std_error",
                ],
            );
            let others = list(&finding["indistinguishable_from"]).iter();
            let others: Vec<Value> = others
                .map(|other| Value::Object(picked(other, &["cause", "address", "probability"])))
                .collect();
            what.insert("indistinguishable_from".to_string(), json!(others));
            Value::Object(what)
        })
        .collect();
    json!({
        "verdict": answer["verdict"],
        "findings": findings,
        "none_of_these": rounded(answer["none_of_these"].as_f64().expect("a probability")),
        "structured": answer["unexplained"]["structured"],
        "parameters": parameters(answer),
        "sweeps": sweeps,
    })
}

/// Returns the recorded part of `identification.json`.
fn identified(answer: &Value) -> Value {
    let mut what = picked(
        answer,
        &["method", "converged", "iterations", "solver_runs"],
    );
    what.insert("fit_test".into(), answer["fit_test"]["verdict"].clone());
    what.insert("parameters".into(), Value::Object(parameters(answer)));
    Value::Object(what)
}

/// Returns the record of one study. For a study that is refused, the reason is recorded.
fn entry(folder: &Path) -> Value {
    let study = match Study::open(folder) {
        Ok(study) => study,
        Err(error) => return json!({ "refused": error.to_string() }),
    };
    let fit = match study.identify(false, &SharedProgress::default()) {
        Ok(answer) => identified(&serde_json::from_str(&answer.fit.to_json()).expect("JSON")),
        Err(error) => json!({ "refused": error.to_string() }),
    };
    let watched = SharedProgress::default();
    let diagnosis = match study.diagnose_checked(false, GainCheck::default(), &watched) {
        Ok(answer) => diagnosed(
            &serde_json::from_str(&answer.diagnosis.to_json()).expect("JSON"),
            watched.stand().done,
        ),
        Err(error) => json!({ "refused": error.to_string() }),
    };
    json!({ "identify": fit, "diagnose": diagnosis })
}

/// Returns true if two numbers agree, within the tolerance of their kind.
fn agree(place: &str, old: f64, new: f64, std_error: Option<f64>) -> bool {
    let key = place.rsplit('.').next().unwrap_or(place);
    let difference = (old - new).abs();
    match key {
        "probability" | "group_probability" | "none_of_these" => difference <= PROBABILITY,
        "sweeps" | "solver_runs" | "iterations" => new <= old * SWEEPS && old <= new * SWEEPS,
        _ => {
            let scale = std_error.unwrap_or_else(|| 0.1 * old.abs().max(new.abs()));
            difference <= OF_STD_ERROR * scale + 2e-3 * old.abs()
        }
    }
}

/// Lists all places where two records differ by more than is allowed.
fn differences(
    place: &str,
    old: &Value,
    new: &Value,
    std_error: Option<f64>,
    found: &mut Vec<String>,
) {
    match (old, new) {
        (Value::Object(a), Value::Object(b)) => {
            let own = old["std_error"].as_f64().or(std_error);
            let keys: std::collections::BTreeSet<&String> = a.keys().chain(b.keys()).collect();
            for key in keys {
                let of_key = old["std_error"][key].as_f64().or(own);
                let place = format!("{place}.{key}");
                let (a, b) = (&old[key], &new[key]);
                if key == "parameters" && old["std_error"].is_object() {
                    for (name, value) in a.as_object().into_iter().flatten() {
                        let error = old["std_error"][name].as_f64();
                        differences(&format!("{place}.{name}"), value, &b[name], error, found);
                    }
                } else {
                    differences(&place, a, b, of_key, found);
                }
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            for (k, (a, b)) in a.iter().zip(b).enumerate() {
                differences(&format!("{place}[{k}]"), a, b, std_error, found);
            }
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().expect("a number"), b.as_f64().expect("a number"));
            if !agree(place, a, b, std_error) {
                found.push(format!("{place}: {a} became {b}"));
            }
        }
        _ if old != new => found.push(format!("{place}: {old} became {new}")),
        _ => {}
    }
}

/// Writes JSON with one finding or parameter of a study per line.
fn write(value: &Value, depth: usize, text: &mut String) {
    let indent = " ".repeat(depth + 1);
    match value {
        Value::Object(members) if depth < 4 && !members.is_empty() => {
            text.push_str("{\n");
            for (k, (key, member)) in members.iter().enumerate() {
                text.push_str(&format!("{indent}{}: ", json!(key)));
                write(member, depth + 1, text);
                text.push_str(if k + 1 < members.len() { ",\n" } else { "\n" });
            }
            text.push_str(&" ".repeat(depth));
            text.push('}');
        }
        Value::Array(members) if depth < 4 && members.iter().any(Value::is_object) => {
            text.push_str("[\n");
            for (k, member) in members.iter().enumerate() {
                text.push_str(&format!("{indent}{member}"));
                text.push_str(if k + 1 < members.len() { ",\n" } else { "\n" });
            }
            text.push_str(&" ".repeat(depth));
            text.push(']');
        }
        other => text.push_str(&other.to_string()),
    }
}

/// Returns the entries of these studies, computed by two threads.
fn entries(of: &BTreeMap<String, PathBuf>) -> BTreeMap<String, Value> {
    let open = Mutex::new(of.iter());
    let made = Mutex::new(BTreeMap::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let next = open.lock().expect("no thread failed").next();
                    let Some((name, folder)) = next else { break };
                    let found = entry(folder);
                    made.lock()
                        .expect("no thread failed")
                        .insert(name.clone(), found);
                }
            });
        }
    });
    made.into_inner().expect("no thread failed")
}

#[test]
fn the_answers_are_those_of_the_record() {
    compare(is_in_sample);
}

#[test]
#[ignore = "minutes: .ci/full"]
fn every_answer_is_that_of_the_record() {
    compare(|_| true);
}

fn compare(chosen: impl Fn(&str) -> bool) {
    let asked = std::env::var("RECORD").unwrap_or_default();
    let mut studies = studies();
    if asked == "write" {
        let mut text = String::new();
        write(&json!(entries(&studies)), 0, &mut text);
        std::fs::write(record_file(), text + "\n").expect("a record that can be written");
        return;
    }
    studies.retain(|name, _| asked == "all" || chosen(name));
    let record = std::fs::read_to_string(record_file()).expect("the record");
    let record: Value = serde_json::from_str(&record).expect("JSON");
    let mut found = Vec::new();
    for (name, new) in entries(&studies) {
        differences(&name, &record[&name], &new, None, &mut found);
    }
    assert!(
        found.is_empty(),
        "the record differs:\n{}",
        found.join("\n")
    );
}
