//! Marks at other positions than in the list of marks on parts, from the first case or from a later one.

use std::path::Path;

use admire_diagnosis::{Cause, Verdict};

use super::axles::{copied, judge};

/// Adds an offset to the coordinates in all lines that a predicate selects.
fn change(table: &Path, is_meant: impl Fn(&str) -> bool, by: [f64; 3]) {
    let text = std::fs::read_to_string(table).unwrap();
    let line = |line: &str| {
        if !is_meant(line) {
            return line.to_string();
        }
        let mut fields: Vec<String> = line.split(',').map(str::to_string).collect();
        let first = fields.len() - 3;
        for (field, by) in fields[first..].iter_mut().zip(by) {
            *field = (field.parse::<f64>().unwrap() + by).to_string();
        }
        fields.join(",")
    };
    let lines: Vec<String> = text.lines().map(line).collect();
    std::fs::write(table, lines.join("\n") + "\n").unwrap();
}

/// Checks a list entry that is wrong by 0.6 mm; the planted cause must be named as without it.
#[test]
fn a_mark_that_is_listed_elsewhere_is_told_once() {
    let name = "tolerances-friction-1";
    let Some(folder) = copied(name) else {
        return;
    };
    let list = folder.path().join(name).join("marks_on_parts.csv");
    change(
        &list,
        |line| line.starts_with("KNUCKLE,3,"),
        [0.4, -0.4, 0.2],
    );
    let judged = judge(folder.path(), name);
    assert_eq!(judged.diagnosis.verdict, Verdict::Discrepancy);
    assert!(judged.named.iter().all(|named| *named));
    assert!(judged.false_names.is_empty(), "{:?}", judged.false_names);
    let findings = judged.diagnosis.findings.iter();
    let of_marks: Vec<_> = findings
        .filter(|finding| finding.cause.is_told_by_marks())
        .collect();
    let [found] = of_marks[..] else {
        panic!("{of_marks:?}");
    };
    assert_eq!(
        (found.cause, found.address.as_str()),
        (Cause::MarkPlace, "KNUCKLE 3")
    );
    assert_eq!(found.form.as_deref(), Some("listed"));
    for (axis, by) in [("x", -0.4), ("y", 0.4), ("z", -0.2)] {
        assert!((found.parameters[axis] - by).abs() < 0.06, "{found:?}");
    }
}

/// Checks a mark that is displaced after two thirds of the cases.
#[test]
fn a_mark_that_came_loose_is_told_once() {
    let name = "clean-1";
    let Some(folder) = copied(name) else {
        return;
    };
    let cases = std::fs::read_to_string(folder.path().join(name).join("load_cases.csv")).unwrap();
    let labels: Vec<&str> = cases
        .lines()
        .skip(1)
        .map(|line| line.split_once(',').unwrap().0)
        .collect();
    let late = &labels[2 * labels.len() / 3..];
    let marks = folder.path().join(name).join("marks_measured.csv");
    let is_meant = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        late.contains(&fields[0]) && fields[1..3] == ["TIE_ROD", "2"]
    };
    change(&marks, is_meant, [0.7, 0.3, -0.5]);
    let judged = judge(folder.path(), name);
    assert_eq!(judged.diagnosis.verdict, Verdict::Consistent);
    let [found] = &judged.diagnosis.findings[..] else {
        panic!("{:?}", judged.diagnosis.findings);
    };
    assert_eq!(
        (found.cause, found.address.as_str()),
        (Cause::MarkPlace, "TIE_ROD 2")
    );
    assert_eq!(found.form.as_deref(), Some("loose"));
}
