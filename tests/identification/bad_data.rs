//! Bad data in a study: `admire identify` names each fault before any fit, and states its consequence.

use std::path::Path;
use std::process::Command;

use crate::setup::copy;

/// Returns the standard error output of `admire identify` for a study with one changed file, and the exit code.
fn said(file: &str, change: impl Fn(&str) -> String) -> (String, i32) {
    let (_folder, path) = copy("pseudo-mcpherson");
    let target = path.join(file);
    let text = std::fs::read_to_string(&target).unwrap();
    let changed = change(&text);
    assert_ne!(text, changed);
    std::fs::write(&target, changed).unwrap();
    identify(&path)
}

fn identify(folder: &Path) -> (String, i32) {
    let out = Command::new(env!("CARGO_BIN_EXE_admire"))
        .args([
            "--format", "plain", "identify", "--method", "direct", "--out",
        ])
        .args([&folder.join("out"), folder])
        .output()
        .unwrap();
    let text = String::from_utf8(out.stderr).unwrap();
    let place = folder.display().to_string();
    (
        text.replace(&format!("{place}/"), ""),
        out.status.code().unwrap(),
    )
}

fn columns_scaled(text: &str, factor: f64) -> String {
    let line = |(k, line): (usize, &str)| {
        if k == 0 {
            return line.to_string();
        }
        let cells: Vec<&str> = line.split(',').collect();
        let (labels, numbers) = cells.split_at(cells.len() - 3);
        let numbers = numbers
            .iter()
            .map(|x| format!("{}", x.parse::<f64>().unwrap() * factor));
        let labels = labels.iter().map(ToString::to_string);
        labels.chain(numbers).collect::<Vec<_>>().join(",")
    };
    text.lines()
        .enumerate()
        .map(line)
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn each_fault_is_named_before_any_fit() {
    let marks = "marks_measured.csv";
    let mut all = String::new();
    let mut add = |what: &str, (said, code): (String, i32)| {
        all.push_str(&format!("{what}: exit {code}\n{said}\n"));
    };
    add(
        "missing marks",
        said(marks, |text| {
            let kept = text
                .lines()
                .filter(|l| !l.starts_with("3,TIE_ROD,2") && !l.starts_with("3,TIE_ROD,3"));
            kept.collect::<Vec<_>>().join("\n")
        }),
    );
    add(
        "swapped marks",
        said(marks, |text| {
            text.replace("\n7,KNUCKLE,1,", "\nswap")
                .replace("\n7,KNUCKLE,2,", "\n7,KNUCKLE,1,")
                .replace("\nswap", "\n7,KNUCKLE,2,")
        }),
    );
    add(
        "duplicated cases",
        said("load_cases.csv", |text| {
            text.to_string() + "13,4500,0,4000\n"
        }),
    );
    add(
        "contradicting cases",
        said("load_cases.csv", |text| {
            text.to_string() + "13,4500,0,1000\n"
        }),
    );
    add("metres", said(marks, |text| columns_scaled(text, 1e-3)));
    add(
        "collinear marks",
        said("marks_on_parts.csv", |text| {
            let line = |line: &str| match line.strip_prefix("TIE_ROD,") {
                Some(rest) => {
                    let mark: f64 = rest.split(',').next().unwrap().parse().unwrap();
                    format!("TIE_ROD,{mark},{},5,5", 50.0 * mark)
                }
                None => line.to_string(),
            };
            text.lines().map(line).collect::<Vec<_>>().join("\n")
        }),
    );
    add(
        "NaN",
        said(marks, |text| {
            let at = text.find("\n2,TIE_ROD,4,").unwrap() + "\n2,TIE_ROD,4,".len();
            let end = at + text[at..].find(',').unwrap();
            format!("{}NaN{}", &text[..at], &text[end..])
        }),
    );
    add(
        "unknown part",
        said(marks, |text| text.replace("KNUCKLE", "KNUCKEL")),
    );
    add(
        "unknown bushing",
        said("study.toml", |text| text.replace("BUSHING/2", "BUSHING/22")),
    );
    insta::assert_snapshot!(all);
}

/// Checks a case with ninety tonnes on one wheel: it is named and left out, and the other cases give the same stiffnesses as without it.
#[test]
fn a_case_the_solver_cannot_reach_is_named_and_left_out() {
    let (_folder, path) = copy("pseudo-mcpherson");
    let target = path.join("load_cases.csv");
    let text = std::fs::read_to_string(&target).unwrap();
    std::fs::write(&target, text.replace("\n13,4500,0,4000", "\n13,900000,0,0")).unwrap();
    let out = Command::new(env!("CARGO_BIN_EXE_admire"))
        .args([
            "--format",
            "json",
            "identify",
            "--method",
            "gauss-newton",
            "--out",
        ])
        .args([&path.join("out"), &path])
        .output()
        .unwrap();
    assert_eq!(out.status.code(), Some(0));
    let page = std::fs::read_to_string(path.join("out/report.html")).unwrap();
    assert!(page.contains("Load case 13 is left out"), "{page}");
    let fit: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    let chi2 = fit["marks"]["chi2_per_dof"].as_f64().unwrap();
    assert!((chi2 - 1.0).abs() < 0.2, "{chi2}");
}

/// Shrinks the marks and the readings of one part, each set towards its own centroid. A rigid motion still maps one set to the other.
fn drawn_together(text: &str, group: usize, part: &str, share: f64) -> String {
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let numbers = |row: &[&str]| -> Vec<f64> {
        let last = row[row.len() - 3..].iter();
        last.map(|x| x.parse().unwrap()).collect()
    };
    let is_same = |a: &[&str], b: &[&str]| a[..=group] == b[..=group];
    let line = |row: &Vec<&str>| {
        if row[group] != part {
            return row.join(",");
        }
        let own: Vec<Vec<f64>> = rows
            .iter()
            .filter(|other| is_same(row, other))
            .map(|other| numbers(other))
            .collect();
        let moved = numbers(row).into_iter().enumerate().map(|(axis, x)| {
            let middle = own.iter().map(|p| p[axis]).sum::<f64>() / own.len() as f64;
            format!("{:.9}", middle + share * (x - middle))
        });
        let labels = row[..row.len() - 3].iter().map(ToString::to_string);
        labels.chain(moved).collect::<Vec<_>>().join(",")
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Runs a study with both files of marks changed. Returns the standard error output and the exit code.
fn both_changed(change: impl Fn(&str, usize) -> String) -> (String, i32) {
    let (_folder, path) = copy("pseudo-mcpherson");
    for (file, group) in [("marks_on_parts.csv", 0), ("marks_measured.csv", 1)] {
        let target = path.join(file);
        let text = std::fs::read_to_string(&target).unwrap();
        std::fs::write(&target, change(&text, group)).unwrap();
    }
    identify(&path)
}

/// Checks marks that are close together, as on a rod. If the readings agree with the list, and the part is where the deck has it, this is no
/// unit error.
#[test]
fn marks_close_together_are_not_taken_for_centimetres() {
    let (said, code) = both_changed(|text, group| drawn_together(text, group, "TIE_ROD", 0.12));
    assert_eq!(code, 0, "{said}");
    assert!(!said.contains("wrong-units"), "{said}");

    let (said, _) = both_changed(|text, _| columns_scaled(text, 0.1));
    let all_listed = "the marks listed on FRONT_ARM seem to be in centimetres";
    assert!(said.contains(all_listed), "{said}");
}
