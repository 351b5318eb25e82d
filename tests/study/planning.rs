//! Proposals of the next measurement: the predicted gains must be realised when it is measured.

use std::collections::BTreeSet;

use admire_design::{Aim, Kind, Plan, Ranked, plan};
use admire_diagnosis::{Progress, fit_with_random_effects};
use admire_identify::LoadedStudy;
use admire_rig::{RigOptions, virtual_rig};
use admire_study::Places;
use nalgebra::DVector;
use serde_json::Value;

use super::run::{admire, change, copied};

/// Measures the shipped McPherson, with its deck as the truth and with further load cases, on the virtual rig.
fn measured(more: &str) -> (tempfile::TempDir, LoadedStudy) {
    let (folder, study) = copied("pseudo-mcpherson");
    std::fs::copy(study.join("reference.adm"), study.join("model.adm")).unwrap();
    let loads = study.join("load_cases.csv");
    let text = std::fs::read_to_string(&loads).unwrap();
    std::fs::write(&loads, text + more).unwrap();
    let options = RigOptions {
        seed: 11,
        ..RigOptions::default()
    };
    let run = virtual_rig(&study, &options).unwrap_or_else(|why| panic!("{why:#?}"));
    let out = folder.path().join("measured");
    for (name, bytes) in &run.files {
        let path = out.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    let checked = LoadedStudy::read(&out);
    let loaded = checked
        .value
        .unwrap_or_else(|| panic!("{:?}", checked.diagnostics));
    (folder, loaded)
}

fn planned(loaded: &LoadedStudy, aim: Aim) -> Plan {
    plan(&loaded.problem(), aim, &Progress::default()).unwrap()
}

/// Returns the standard deviation of a combination of ln K, by an identification with tolerances.
fn identified(loaded: &LoadedStudy, vector: &[f64]) -> f64 {
    let found = fit_with_random_effects(&loaded.problem()).unwrap();
    let v = DVector::from_column_slice(vector);
    v.dot(&(found.covariance(v.len()) * &v)).sqrt()
}

/// Returns the first load case of a candidate as a row of the shipped file.
fn row(ranked: &Ranked, label: &str) -> String {
    let of = |name: &str| ranked.cases[0][name];
    let values = ["vertical", "lateral", "longitudinal"].map(of);
    format!("{label},{},{},{}\n", values[0], values[1], values[2])
}

/// Checks that the gain of the suggested case is realised when it is measured and everything is identified again, including variance components.
/// The noise is that of the rig.
#[test]
fn a_case_does_what_the_plan_promised_and_more_than_the_last_one() {
    let (_folder, before) = measured("");
    let found = planned(&before, Aim::Stiffnesses);
    let with_cases: Vec<&Ranked> = found
        .candidates
        .iter()
        .filter(|c| c.cases.len() == 1)
        .collect();
    let (best, last) = (with_cases[0], with_cases[with_cases.len() - 1]);
    // Combination that the sentence names: the one with the largest gain. Poorly determined combinations are excluded, because their posterior
    // is not Gaussian.
    let (at, _) = found
        .combinations
        .iter()
        .enumerate()
        .filter(|(_, c)| c.sd_log < 0.5)
        .min_by(|(a, ca), (b, cb)| {
            (best.sd_log[*a] / ca.sd_log).total_cmp(&(best.sd_log[*b] / cb.sd_log))
        })
        .unwrap();
    let (named, promised) = (&found.combinations[at], best.sd_log[at]);
    assert!(promised < 0.6 * named.sd_log, "{named:?} {promised}");
    let known = identified(&before, &named.vector);
    assert!((known / named.sd_log - 1.0).abs() < 1e-9);
    let [with_best, with_last] = [best, last].map(|ranked| {
        let (_folder, after) = measured(&row(ranked, "next"));
        identified(&after, &named.vector)
    });
    assert!(
        (with_best / promised - 1.0).abs() < 0.3,
        "{}: {} promised {promised}, came {with_best}",
        best.what,
        named.sd_log
    );
    assert!(
        with_best < 0.8 * with_last,
        "{with_best}, {}: {with_last}",
        last.what
    );
}

#[test]
fn a_case_that_is_there_many_times_ranks_low() {
    let place = |found: &Plan| {
        let single: Vec<&Ranked> = found
            .candidates
            .iter()
            .filter(|c| c.cases.len() == 1)
            .collect();
        let of = |c: &&Ranked| c.kind == Kind::Repeat && c.what.starts_with("case 1 again");
        let at = single.iter().position(of).unwrap();
        (at as f64 / single.len() as f64, single[at].score)
    };
    let (_folder, once) = measured("");
    let (before, gain_before) = place(&planned(&once, Aim::Stiffnesses));
    let copies: Vec<String> = (0..12).map(|k| format!("r{k},1500,0,0\n")).collect();
    let (_folder, often) = measured(&copies.concat());
    let found = planned(&often, Aim::Stiffnesses);
    let (after, gain_after) = place(&found);
    assert!(
        found
            .candidates
            .iter()
            .any(|c| c.what == "case 1 again (measured 13 times so far)")
    );
    // Measured once, the case shows the stiffnesses at a low load; measured a fourteenth time, it shows nothing new.
    assert!(before < 0.6 && after > 0.75, "{before} {after}");
    assert!(gain_after < 0.2 * gain_before, "{gain_before} {gain_after}");
}

#[test]
fn readings_and_curves_alone_are_planned_for() {
    for (study, unread) in [("flexure-finger", true), ("kc-curves", false)] {
        let (_folder, path) = copied(study);
        let mut loaded = LoadedStudy::read(&path).value.unwrap();
        loaded.measurement.available.load_cells = Places::Everywhere;
        let found = planned(&loaded, Aim::Curves);
        let best = &found.candidates[0];
        let (before, after) = (found.curves.as_ref().unwrap().sd, best.curves.unwrap());
        assert!(best.score > 0.2, "{study}: {best:?}");
        assert!(after.toe_deg < before.toe_deg && after.position < before.position);
        // Toe, camber and centre are read by the rig of one study, but not by the sensors of the other.
        let curves = found.candidates.iter().any(|c| c.kind == Kind::Curve);
        assert_eq!(curves, unread, "{study}");
        for kind in [Kind::Load, Kind::Repeat, Kind::Mark, Kind::LoadCell] {
            assert!(
                found.candidates.iter().any(|c| c.kind == kind),
                "{study} {kind:?}"
            );
        }
        // A further measurement never reduces the knowledge.
        for candidate in &found.candidates {
            let sds = found.combinations.iter().zip(&candidate.sd_log);
            let worse =
                |(c, sd): (&admire_design::Combination, &f64)| *sd > c.sd_log * (1.0 + 1e-9);
            assert!(!sds.clone().any(worse), "{study}: {candidate:?}");
        }
    }
}

fn fields(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        // Names from the study itself.
        Value::Object(_) if matches!(path.rsplit('.').next(), Some("combination" | "cases")) => {}
        Value::Object(object) => {
            for (key, value) in object {
                let whole = if path.is_empty() {
                    key.clone()
                } else {
                    format!("{path}.{key}")
                };
                found.insert(whole.clone());
                fields(value, &whole, found);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| fields(item, path, found)),
        _ => {}
    }
}

/// Checks that the rows are appended to the study's own file, whatever its format, and that the study remains valid.
#[test]
fn suggested_cases_are_rows_of_the_study() {
    let (folder, study) = copied("pseudo-mcpherson");
    // The file is written by a spreadsheet: semicolons, decimal commas, an extra column, and no line end after the last line.
    let loads = study.join("load_cases.csv");
    let text = std::fs::read_to_string(&loads).unwrap();
    let rows = text.lines().filter(|line| !line.starts_with('#'));
    let rows: Vec<String> = rows
        .enumerate()
        .map(|(k, line)| {
            let remark = if k == 0 { "remark" } else { "0,5" };
            format!("{remark};{}", line.replace(',', ";"))
        })
        .collect();
    std::fs::write(&loads, rows.join("\r\n")).unwrap();
    let words = [
        "plan",
        "study",
        "--for",
        "stiffnesses",
        "--count",
        "6",
        "--out",
        "next",
    ];
    let said = admire(folder.path(), &words);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.out.lines().all(|line| line.chars().count() <= 80),
        "{}",
        said.out
    );
    assert!(said.out.contains("\nNext: "), "{}", said.out);
    let rows = std::fs::read_to_string(folder.path().join("next/suggested.csv")).unwrap();
    let count = rows.lines().filter(|l| l.contains(";plan-")).count();
    assert!(count >= 3, "{rows}");
    let whole = std::fs::read_to_string(&loads).unwrap() + &rows;
    std::fs::write(&loads, whole).unwrap();
    let read = LoadedStudy::read(&study).value.unwrap();
    assert_eq!(read.measurement.cases.len(), 13 + count);
    assert_eq!(read.measurement.cases[13].label, "plan-1");
    // Every field is explained.
    let json = std::fs::read_to_string(folder.path().join("next/plan.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    let best = json["candidates"].as_array().unwrap();
    let best = best.iter().find(|c| c["kind"] == "load").unwrap();
    assert_eq!(
        best["cases"][0]["vertical"],
        read.measurement.cases[13].loads[0]
    );
    let mut found = BTreeSet::new();
    fields(&json, "", &mut found);
    let entries: Vec<_> = admire_guide::glossary::entries()
        .filter(|entry| entry.page == "plan")
        .map(|entry| entry.term)
        .collect();
    let lacking: Vec<_> = found
        .iter()
        .filter(|field| !entries.contains(field))
        .collect();
    assert!(lacking.is_empty(), "{lacking:?}");
    // Files of an earlier run are replaced; files that somebody changed are not.
    assert_eq!(admire(folder.path(), &words).code, 0);
    change(&folder.path().join("next/plan.json"), "aim", "mine");
    let refused = admire(folder.path(), &words);
    assert_eq!(refused.code, 1);
    assert!(refused.err.contains("plan.json"), "{}", refused.err);
}

/// Checks a top mount 2.5 times as stiff as in the deck. Marks alone do not determine which of its laws is wrong. The plan names a measurement
/// that decides it, and the measurement does.
#[test]
fn what_is_undecided_is_decided_by_what_the_plan_names() {
    let (folder, study) = copied("pseudo-mcpherson");
    let rig = |out: &str| {
        let effect = "element-parameter@BUSHING/3.K.1:factor=2.5";
        let words = [
            "rig", "study", "--out", out, "--effect", effect, "--seed", "6",
        ];
        let said = admire(folder.path(), &words);
        assert_eq!(said.code, 0, "{}", said.err);
    };
    rig("before");
    let words = [
        "plan", "before", "--for", "causes", "--count", "3", "--out", "next",
    ];
    // No load separates the causes. The study lists no load cell, so none is proposed; the plan names a load cell as an instrument that would
    // separate them.
    let said = admire(folder.path(), &words);
    assert_eq!(said.code, 0, "{}", said.err);
    let text = said.out.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        text.contains("no load in the range distinguishes the two"),
        "{text}"
    );
    assert!(
        text.contains("load cell in BUSHING/3 (chi-square"),
        "{text}"
    );
    assert!(text.contains("not listed as available"), "{text}");
    assert!(!text.contains("Next: load cell"), "{text}");
    let before = folder.path().join("before/study.toml");
    let toml = std::fs::read_to_string(&before).unwrap();
    let cell =
        "\n[plan]\navailable = [\"loads\", \"repeats\", \"marks\", \"load cell in BUSHING/3\"]\n";
    std::fs::write(&before, toml + cell).unwrap();
    let said = admire(folder.path(), &words);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.out.contains("undecided: ") && said.out.contains("Next: load cell in BUSHING/3."),
        "{}",
        said.out
    );
    let json = std::fs::read_to_string(folder.path().join("next/plan.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    let between = json["causes"]["between"].as_array().unwrap();
    assert!(
        between
            .iter()
            .all(|name| name.as_str().unwrap().ends_with("BUSHING/3.K.1"))
    );
    let shift = |k: usize| {
        let candidates = json["candidates"].as_array().unwrap();
        candidates[k]["causes"]["probability_shift"]
            .as_f64()
            .unwrap()
    };
    let last = json["candidates"].as_array().unwrap().len() - 1;
    assert!(
        shift(0) > 0.2 && shift(last) < 0.05,
        "{} {}",
        shift(0),
        shift(last)
    );
    let probability = |study: &str| {
        let out = format!("{study}-out");
        let words = [
            "diagnose",
            study,
            "--out",
            &out,
            "--check-gain",
            "quick",
            "--format",
            "json",
        ];
        let said = admire(folder.path(), &words);
        assert_eq!(said.code, 0, "{}", said.err);
        let found: Value = serde_json::from_str(&said.out).unwrap();
        let findings = found["findings"].as_array().unwrap();
        let own = |f: &&Value| f["cause"] == "element-parameter" && f["address"] == "BUSHING/3.K.1";
        let found = findings.iter().find(own);
        found.map_or(0.0, |f| f["probability"].as_f64().unwrap())
    };
    let before = probability("before");
    // Noise of half a percent of the largest force, which the plan assumes for a load cell.
    let cells = "\n[readings]\nfile = \"readings.csv\"\n[readings.channels]\n\
                 fx = { function = \"BUSH(3,0,2,0)\", sigma = 20.0 }\n\
                 fy = { function = \"BUSH(3,0,3,0)\", sigma = 20.0 }\n\
                 fz = { function = \"BUSH(3,0,4,0)\", sigma = 20.0 }\n";
    let toml = std::fs::read_to_string(study.join("study.toml")).unwrap();
    std::fs::write(study.join("study.toml"), toml + cells).unwrap();
    std::fs::write(study.join("readings.csv"), "case,fx,fy,fz\n").unwrap();
    rig("after");
    let after = probability("after");
    assert!(after > 0.9 && after > before + 0.2, "{before} {after}");
}

/// Checks that only instruments of the laboratory are proposed, and no load beyond the range in the study.
#[test]
fn nothing_is_proposed_that_the_laboratory_lacks() {
    let planned_with = |available: &str| {
        let (folder, study) = copied("pseudo-mcpherson");
        let toml = study.join("study.toml");
        let text = std::fs::read_to_string(&toml).unwrap();
        std::fs::write(
            &toml,
            format!("{text}\n[plan]\navailable = [{available}]\n"),
        )
        .unwrap();
        let words = ["--format", "json", "plan", "study", "--for", "stiffnesses"];
        admire(folder.path(), &words)
    };
    let said = planned_with("'load lateral from -500 to 250', 'marks on PART/3'");
    assert_eq!(said.code, 0, "{}", said.err);
    let found: Value = serde_json::from_str(&said.out).unwrap();
    let candidates = found["candidates"].as_array().unwrap();
    let kinds: BTreeSet<&str> = candidates
        .iter()
        .filter_map(|c| c["kind"].as_str())
        .collect();
    assert_eq!(kinds, BTreeSet::from(["load", "mark"]));
    let cases: Vec<&Value> = candidates
        .iter()
        .filter_map(|c| c["cases"].get(0))
        .collect();
    let lateral: Vec<f64> = cases.iter().filter_map(|c| c["lateral"].as_f64()).collect();
    assert!(
        lateral.contains(&-500.0) && lateral.contains(&250.0),
        "{lateral:?}"
    );
    assert_eq!(cases.len(), 2, "{cases:?}");
    let marks = candidates.iter().filter(|c| c["kind"] == "mark").count();
    assert_eq!(marks, 1, "{candidates:?}");
    for (entry, says) in [
        ("'marks on WHEEEL'", "the unknown part `WHEEEL`"),
        (
            "'load cell in BUSHING/9'",
            "the unknown bushing or joint `BUSHING/9`",
        ),
        (
            "'load lateral from 3 to 2'",
            "is not an entry of `plan.available`",
        ),
        ("'load side'", "the unknown load column `side`"),
        ("'scales'", "is not an entry of `plan.available`"),
    ] {
        let said = planned_with(entry);
        assert_eq!(said.code, 1, "{entry}: {}", said.err);
        assert!(said.err.contains(says), "{entry}: {}", said.err);
    }
}

#[test]
fn what_cannot_be_planned_is_refused() {
    let (folder, study) = copied("pseudo-mcpherson");
    let toml = study.join("study.toml");
    change(
        &toml,
        "bushings = [\"BUSHING/1\", \"BUSHING/2\"]",
        "bushings = []",
    );
    let said = admire(folder.path(), &["plan", "study", "--for", "stiffnesses"]);
    assert_eq!(said.code, 1, "{}", said.out);
    assert!(
        said.err.contains("no parameters to identify"),
        "{}",
        said.err
    );
    let none = admire(folder.path(), &["plan", "study", "--count", "0"]);
    assert_eq!(none.code, 2);
    let nowhere = admire(folder.path(), &["plan", "nothing"]);
    assert_eq!(nowhere.code, 1);
}
