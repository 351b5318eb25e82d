//! The same axle in another unit of length must have the same diagnosis.

use std::path::Path;

use admire_diagnosis::{Diagnosis, GainCheck, Parameter, Progress, diagnose_watched, held_out};
use admire_identify::{LoadedStudy, Status};

use crate::common::shared;

fn scaled(numbers: &str, by: f64) -> String {
    let numbers = numbers.split(',').map(|n| n.trim().parse::<f64>().unwrap());
    let numbers: Vec<String> = numbers.map(|n| format!("{:?}", n * by)).collect();
    numbers.join(", ")
}

/// Converts a deck from millimetres to a unit of which `scale` units are one millimetre.
fn deck(text: &str, word: &str, scale: f64) -> String {
    let line = |line: &str| {
        let Some((key, numbers)) = line.split_once(" = ") else {
            return line.replace("MILLIMETER", word);
        };
        let by = match key {
            ", QP" | ", QG" | ", LENGTH" | ", KT" | ", KGRAV" => scale,
            ", IP" => scale * scale,
            ", K" => 1.0 / scale,
            _ => return line.to_string(),
        };
        format!("{key} = {}", scaled(numbers, by))
    };
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

/// Converts a table of marks, whose last three columns are lengths.
fn table(text: &str, scale: f64) -> String {
    let line = |line: &str| {
        let at = line.match_indices(',').rev().nth(2).unwrap().0;
        format!("{},{}\n", &line[..at], scaled(&line[at + 1..], scale))
    };
    let (header, rows) = text.split_once('\n').unwrap();
    format!("{header}\n{}", rows.lines().map(line).collect::<String>())
}

fn diagnosis(folder: &Path) -> Diagnosis {
    let loaded = LoadedStudy::read(folder).value.unwrap();
    let held = held_out(&loaded.study, &loaded.measurement);
    let found = diagnose_watched(
        &loaded.problem(),
        held,
        GainCheck::Quick,
        &Progress::default(),
    );
    found.unwrap().diagnosis
}

/// Checks that built-in defaults, such as initial stiffnesses and bushing offsets, have the same physical size in every unit.
#[test]
fn an_axle_in_metres_and_in_inches_has_the_same_diagnosis() {
    let Some(folder) = shared("reference/realistic-axles/hardpoint-0") else {
        return;
    };
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let known = diagnosis(&folder);
    assert_eq!(known.findings.len(), 1);
    for (word, scale) in [("METER", 1e-3), ("INCH", 1.0 / 25.4)] {
        let other = tempfile::tempdir().unwrap();
        let write = |name: &str, text: String| {
            std::fs::write(other.path().join(name), text).unwrap();
        };
        write("model.adm", deck(&read("model.adm"), word, scale));
        for name in ["marks_on_parts.csv", "marks_measured.csv"] {
            write(name, table(&read(name), scale));
        }
        write("load_cases.csv", read("load_cases.csv"));
        let study = read("study.toml");
        let sigma = study
            .lines()
            .find(|line| line.starts_with("sigma"))
            .unwrap();
        let (key, value) = sigma.split_once(" = ").unwrap();
        let sigma_there = format!("{key} = {}", scaled(value, scale));
        write("study.toml", study.replace(sigma, &sigma_there));
        let found = diagnosis(other.path());
        assert_eq!(found.verdict, known.verdict, "{word}");
        let [finding] = &found.findings[..] else {
            panic!("{word}: {:#?}", found.findings);
        };
        let own = &known.findings[0];
        assert_eq!(
            (finding.cause, &finding.address),
            (own.cause, &own.address),
            "{word}"
        );
        assert!(
            (finding.probability - own.probability).abs() < 1e-6,
            "{word}"
        );
        for (name, value) in &own.parameters {
            let there = finding.parameters[name] / scale;
            assert!(
                (there - value).abs() < 1e-4 * value.abs(),
                "{word}: {name} {there} {value}"
            );
        }
        let identified = |p: &&Parameter| p.status == Status::Identified;
        let pairs = known.parameters.iter().zip(&found.parameters);
        for (own, there) in pairs.filter(|(own, _)| identified(own)) {
            let power = if own.address.contains("KT") {
                scale
            } else {
                1.0 / scale
            };
            let ratio = there.value / own.value / power;
            assert!(
                (ratio - 1.0).abs() < 1e-4,
                "{word}: {} {ratio}",
                own.address
            );
        }
    }
}
